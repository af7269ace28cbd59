#include "core/exact_sum.hpp"

#include <bit>
#include <cmath>
#include <limits>

namespace nappe {

namespace {

constexpr int lowest_exponent = -1088; // below the smallest subnormal, 2^-1074, and a multiple of 32

} // namespace

void ExactSum::add(double term) {
    const auto bits = std::bit_cast<std::uint64_t>(term);
    const int biased = static_cast<int>((bits >> 52) & 0x7ff);
    if (biased == 0x7ff) {
        limbs_[n_limbs] += 1;
        return;
    }
    std::uint64_t mantissa = bits & ((std::uint64_t{1} << 52) - 1);
    if (biased != 0) {
        mantissa |= std::uint64_t{1} << 52;
    }
    const int exponent = (biased != 0 ? biased : 1) - 1075; // term = mantissa x 2^exponent
    const int position = exponent - lowest_exponent;
    const int limb = position / 32;
    const int shift = position % 32;
    const std::uint64_t low = (mantissa & 0xffffffffu) << shift; // at most 63 bits
    const std::uint64_t high = (mantissa >> 32) << shift;        // at most 52 bits
    const std::int64_t sign = (bits >> 63) != 0 ? -1 : 1;
    limbs_[limb] += sign * static_cast<std::int64_t>(low & 0xffffffffu);
    limbs_[limb + 1] += sign * static_cast<std::int64_t>((low >> 32) + (high & 0xffffffffu));
    limbs_[limb + 2] += sign * static_cast<std::int64_t>(high >> 32);
}

void ExactSum::add(const ExactSum& other) {
    for (std::size_t k = 0; k < limbs_.size(); ++k) {
        limbs_[k] += other.limbs_[k];
    }
}

double ExactSum::value() const {
    if (limbs_[n_limbs] != 0) {
        return std::numeric_limits<double>::quiet_NaN();
    }
    // Carry so that every limb but the top one is in [0, 2^32); the sign is then that of the top limb.
    std::array<std::int64_t, n_limbs> digits;
    std::int64_t carry = 0;
    for (int k = 0; k < n_limbs; ++k) {
        const std::int64_t total = limbs_[k] + carry;
        carry = total >> 32;
        digits[k] = total - (carry << 32);
    }
    const bool negative = carry < 0;
    if (negative) { // two's complement over all limbs
        std::int64_t borrow = 1;
        for (int k = 0; k < n_limbs; ++k) {
            const std::int64_t total = (0xffffffff - digits[k]) + borrow;
            borrow = total >> 32;
            digits[k] = total & 0xffffffff;
        }
    }
    int top = n_limbs - 1;
    while (top > 0 && digits[top] == 0) {
        --top;
    }
    if (digits[top] == 0) {
        return 0;
    }
    // The 64 leading bits, the last of them set if anything lies below: all that rounding to the nearest double needs.
    const auto digit = [&](int k) { return k >= 0 ? static_cast<std::uint64_t>(digits[k]) : 0; };
    const int shift = std::countl_zero(static_cast<std::uint32_t>(digits[top]));
    const std::uint64_t third = digit(top - 2) << shift;
    std::uint64_t leading = (((digit(top) << 32) | digit(top - 1)) << shift) | (third >> 32);
    bool below = (third & 0xffffffffu) != 0;
    for (int k = top - 3; k >= 0 && !below; --k) {
        below = digits[k] != 0;
    }
    leading |= below ? 1 : 0;
    const double magnitude = std::ldexp(static_cast<double>(leading), 32 * (top - 1) - shift + lowest_exponent);
    return negative ? -magnitude : magnitude;
}

} // namespace nappe
