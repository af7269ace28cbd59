#pragma once
// Sums that do not depend on the order of their terms: a fixed-point accumulator wide enough for every double, whose
// integer limbs may be added up over ranks. A sum that steers or is reported is first formed by tile in a fixed order,
// then over tiles with this.

#include <array>
#include <cstdint>
#include <span>

namespace nappe {

/// Holds any sum of fewer than 2^30 finite doubles without rounding. 68 limbs of 32 bits in 64-bit integers, the spare
/// bits take the carries.
class ExactSum {
public:
    static constexpr int n_limbs = 68;

    /// Local. A term that is not finite makes the sum not finite; it is never lost.
    void add(double term);

    /// Local.
    void add(const ExactSum& other);

    void clear() { limbs_.fill(0); }

    /// Local. The sum rounded once, to the nearest double: the same whatever the order was.
    double value() const;

    /// For Communicator::sum over ranks.
    std::span<std::int64_t> limbs() { return limbs_; }

private:
    // Limb k weighs 2^(32 k - 1088); the last one counts terms that are not finite.
    std::array<std::int64_t, n_limbs + 1> limbs_{};
};

} // namespace nappe
