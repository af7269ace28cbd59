#pragma once
// The resident set of this process, as the system counts it.

#include <cstdint>
#include <string_view>

namespace nappe {

struct ResidentSet {
    std::int64_t now = 0;     ///< VmRSS [bytes]
    std::int64_t highest = 0; ///< VmHWM [bytes]: since the process began, or since forget_highest
};

/// **Local.** Zeros where the system has no /proc/self/status.
ResidentSet resident_set();

/// **Local.** From the text of /proc/self/status.
ResidentSet parse_resident_set(std::string_view status);

/// **Local.** Lets `highest` begin anew, where the system allows it (Linux: /proc/self/clear_refs).
void forget_highest();

/// **Local.** Gives the system back what the allocator keeps for later.
void return_free_memory();

} // namespace nappe
