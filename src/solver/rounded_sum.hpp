#pragma once
// Sums over contacts in whatever order their lanes have: every term is first rounded to a multiple of one unit, which is
// chosen from the size of the sum that is expected, and then nothing is rounded any more (the idea of pre-rounding,
// Demmel and Nguyen 2013). The sum is good to 2^-30 of its scale a term, enough for what steers a method.

#include "solver/disk_batch.hpp"

#include <cmath>
#include <cstdint>

namespace nappe {

/// A sum of 0 may be one so much smaller than its scale that all terms were rounded off: the next scale over this one.
inline constexpr double rounded_off = 0x1p-24;

class RoundedSum {
public:
    /// @param scale what the sum may be like, > 0; the same on all ranks
    explicit RoundedSum(double scale) : unit_(std::ldexp(1.0, std::ilogb(scale > least ? scale : least) - 29)) {}

    /// Terms above 32 scales count as 32 scales: 2^18 of them in a tile still add up exactly.
    TermRounding rounding() const { return {0x1.8p52 * unit_, 0x1p35 * unit_}; }

    /// Local. The sum of terms so rounded.
    void add(double of_tile) { units_ += std::llround(of_tile / unit_); }

    std::int64_t& units() { return units_; } ///< to be summed over ranks
    double value() const { return static_cast<double>(units_) * unit_; }

private:
    static constexpr double least = 1e-250;
    double unit_;
    std::int64_t units_ = 0;
};

} // namespace nappe
