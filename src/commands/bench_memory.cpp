#include "commands/bench_memory.hpp"

#include <charconv>
#include <fstream>
#include <iterator>
#include <string>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace nappe {

namespace {

/// "VmRSS:     1234 kB" in bytes; 0 if there is no such line.
std::int64_t bytes_of(std::string_view status, std::string_view key) {
    const auto line = status.find(key);
    if (line == std::string_view::npos) {
        return 0;
    }
    const auto digit = status.find_first_of("0123456789", line + key.size());
    std::int64_t kilobytes = 0;
    if (digit != std::string_view::npos) {
        std::from_chars(status.data() + digit, status.data() + status.size(), kilobytes);
    }
    return 1024 * kilobytes;
}

} // namespace

ResidentSet parse_resident_set(std::string_view status) {
    return {bytes_of(status, "VmRSS:"), bytes_of(status, "VmHWM:")};
}

ResidentSet resident_set() {
    std::ifstream file("/proc/self/status");
    return parse_resident_set(std::string(std::istreambuf_iterator<char>(file), {}));
}

void forget_highest() {
    std::ofstream("/proc/self/clear_refs") << "5\n";
}

void return_free_memory() {
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

} // namespace nappe
