#pragma once
// Memory bandwidth by a triad, a[i] = b[i] + s c[i], at the size of a sweep's working set.

#include "parallel/communicator.hpp"

#include <cstdint>

namespace nappe {

struct TriadFigures {
    std::int64_t bytes = 0; ///< of the three arrays, on the rank with most
    double best = 0;        ///< [GB/s] per rank, triad_bytes counted per element
    double median = 0;      ///< [GB/s]
    int samples = 0;        ///< timings; of small arrays each is of many passes
    bool right = false;     ///< a holds what it should
};

/// **Collective.** All ranks at once, each on arrays of `bytes` in all; a timing counts with its slowest rank.
/// @param seconds to spend at least, and at least ten timings
TriadFigures measure_triad(const Communicator& comm, std::int64_t bytes, double seconds);

} // namespace nappe
