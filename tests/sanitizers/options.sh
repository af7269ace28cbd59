# How the sanitizers of the preset asan behave; tools/test --asan sources it once build/asan is there, and so may you before
# you start build/asan/nappe by hand. `root` is the top of the repository.
#   exitcode=99                     no code of nappe's own: a test that expects a failure does not take a finding for it
#   detect_leaks=1                  all that is not freed when a rank ends; what libraries keep is in lsan.supp
#   detect_stack_use_after_return   a reference to a local that is gone; g++ 12 looks for it only if told
#   check_initialization_order      a global that reads one of another file before it is made
#   verify_asan_link_order=0        the two libraries that tests preload need not come after the sanitizer's
#   intercept_tls_get_addr=0        what plugins keep per thread is not looked through for pointers: g++ 12's guess at where
#                                   such a block begins goes wrong when it lies 16 bytes into a page, and LeakSanitizer dies
#   allocator_may_return_null=1     a size nobody can have is std::bad_alloc, as without sanitizers, and has its message
export ASAN_OPTIONS=exitcode=99:detect_leaks=1:detect_stack_use_after_return=1:check_initialization_order=1
ASAN_OPTIONS+=:verify_asan_link_order=0:intercept_tls_get_addr=0:allocator_may_return_null=1
export UBSAN_OPTIONS=exitcode=99:print_stacktrace=1
# print_suppressions=0: what was passed over would stand after every program's own last line.
export LSAN_OPTIONS=suppressions=$root/tests/sanitizers/lsan.supp:print_suppressions=0
export LD_PRELOAD=$root/build/asan/tests/sanitizers/libkeep_modules.so
