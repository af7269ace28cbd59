# What every target of nappe compiles with. -ffp-contract=off is part of the physics: g++ fuses multiply and add, which
# would make a result depend on the instruction set (docs/architecture.md, "Rules that keep the bits").
add_library(nappe_options INTERFACE)
target_compile_options(nappe_options INTERFACE
  -ffp-contract=off -fno-math-errno
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor -Woverloaded-virtual)
# Where sources are compiled several at a time, a name of one may stand for something local in another; and g++ takes all but
# the main file for headers, which must not show others what is in their anonymous namespaces.
set(together "$<BOOL:$<TARGET_PROPERTY:UNITY_BUILD>>")
target_compile_options(nappe_options INTERFACE
  $<${together}:-Wno-shadow> $<$<AND:${together},$<CXX_COMPILER_ID:GNU>>:-Wno-subobject-linkage>)
if(NAPPE_AUDIT OR CMAKE_BUILD_TYPE STREQUAL "Debug")
  target_compile_definitions(nappe_options INTERFACE NAPPE_ASSERTIONS=1)
endif()
