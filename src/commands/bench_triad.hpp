#pragma once
// Memory bandwidth by a triad, a[i] = b[i] + s c[i], at the size of a sweep's working set.

#include "parallel/communicator.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace nappe {

/// Three arrays and the loop over them. Local.
class Triad {
public:
    /// @param bytes of the three together, in whole lines of 64 bytes; at least one line each
    explicit Triad(std::int64_t bytes);

    void pass(int times);
    std::int64_t bytes() const; ///< that a pass is charged with
    bool right() const;         ///< after a pass: a holds what it should

private:
    struct alignas(64) Line { ///< else every load of 512 bits would cross two lines
        std::array<double, 8> value;
    };
    static constexpr double b_value = 1, c_value = 2, s = 3;

    std::vector<Line> a_, b_, c_;
};

struct TriadFigures {
    std::int64_t bytes = 0; ///< of the three arrays, on the rank with most
    double best = 0;        ///< [GB/s] per rank, triad_bytes counted per element
    double median = 0;      ///< [GB/s]
    int samples = 0;        ///< timings; of small arrays each is of many passes
    bool right = false;     ///< a holds what it should
};

/// **Collective.** All ranks at once, each on arrays of its own; a timing counts with its slowest rank.
/// @param seconds to spend at least, and at least ten timings
TriadFigures measure_triad(const Communicator& comm, Triad& triad, double seconds);

} // namespace nappe
