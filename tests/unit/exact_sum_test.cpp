// ExactSum: exact whatever the order and size of its terms, rounded once.

#include "core/exact_sum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace nappe {
namespace {

using limits = std::numeric_limits<double>;

double exact(const std::vector<double>& terms) {
    ExactSum sum;
    for (const double term : terms) {
        sum.add(term);
    }
    return sum.value();
}

/// Random signs, mantissas and exponents in [-wide, wide].
std::vector<double> random_terms(std::size_t n, int wide, std::uint64_t seed) {
    std::mt19937_64 bits(seed);
    std::vector<double> terms(n);
    for (auto& term : terms) {
        const double mantissa = static_cast<double>(static_cast<std::int64_t>(bits())) * 0x1p-63;
        term = std::ldexp(mantissa, static_cast<int>(bits() % static_cast<std::uint64_t>(2 * wide + 1)) - wide);
    }
    return terms;
}

TEST(ExactSum, OrderHasNoInfluence) {
    for (const int wide : {2, 60, 500, 1000}) {
        auto terms = random_terms(2000, wide, 7);
        const double first = exact(terms);
        std::mt19937_64 shuffler(11);
        for (int k = 0; k < 5; ++k) {
            std::shuffle(terms.begin(), terms.end(), shuffler);
            EXPECT_EQ(std::bit_cast<std::uint64_t>(exact(terms)), std::bit_cast<std::uint64_t>(first)) << wide;
        }
        EXPECT_NE(first, 0);
    }
}

TEST(ExactSum, PartsAddedUpAreTheWhole) {
    const auto terms = random_terms(999, 300, 3);
    ExactSum whole, total;
    std::array<ExactSum, 3> parts;
    for (std::size_t k = 0; k < terms.size(); ++k) {
        whole.add(terms[k]);
        parts[k % 3].add(terms[k]);
    }
    for (const auto& part : parts) {
        total.add(part);
    }
    EXPECT_EQ(total.value(), whole.value());
    // The same through the limbs, as ranks add them.
    ExactSum by_limbs;
    for (auto& part : parts) {
        for (std::size_t k = 0; k < part.limbs().size(); ++k) {
            by_limbs.limbs()[k] += part.limbs()[k];
        }
    }
    EXPECT_EQ(by_limbs.value(), whole.value());
}

TEST(ExactSum, KnownSums) {
    const struct {
        std::vector<double> terms;
        double sum;
    } cases[] = {
        {{}, 0},
        {{-0.0}, 0},
        {{1.5}, 1.5},
        {{-1.5}, -1.5},
        {{1, 2, 3, 4.25}, 10.25},
        {{1, -2, 3, -4.25}, -2.25},
        {{1e300, 1, -1e300}, 1},
        {{-1e300, 1e-300, 1e300}, 1e-300},
        {{1e300, -1, -1e300}, -1},
        {{0x1p1023, 0x1p-1074, -0x1p1023}, 0x1p-1074},
        {{limits::max(), limits::max(), -limits::max()}, limits::max()},
        {{limits::max(), -limits::max()}, 0},
        {{-limits::max(), -limits::max(), limits::max()}, -limits::max()},
        {{limits::denorm_min(), limits::denorm_min(), limits::denorm_min()}, 3 * limits::denorm_min()},
        {{-limits::denorm_min()}, -limits::denorm_min()},
        {{limits::min(), -limits::denorm_min()}, limits::min() - limits::denorm_min()},
        {{1, limits::denorm_min(), -1, -limits::denorm_min()}, 0},
        {{0x1p53, 1, 1}, 0x1p53 + 2},
    };
    for (const auto& c : cases) {
        EXPECT_EQ(exact(c.terms), c.sum) << "sum " << c.sum << " of " << c.terms.size() << " terms";
    }
    EXPECT_EQ(std::bit_cast<std::uint64_t>(exact({1, -1})), 0u) << "an empty sum is +0";
}

/// Rounded once, to nearest: what lies below the last bit decides a tie.
TEST(ExactSum, RoundsToNearest) {
    for (const double sign : {1.0, -1.0}) {
        EXPECT_EQ(exact({sign * 0x1p53, sign}), sign * 0x1p53) << "a tie goes to even";
        EXPECT_EQ(exact({sign * 0x1p53, sign, sign * 0x1p-20}), sign * (0x1p53 + 2)) << "above the tie";
        EXPECT_EQ(exact({sign * 0x1p53, sign, sign * 0x1p-600}), sign * (0x1p53 + 2))
            << "above the tie, by very little";
        EXPECT_EQ(exact({sign * 0x1p53, sign, sign * -0x1p-600}), sign * 0x1p53) << "below the tie, by very little";
    }
}

/// Terms of similar size: 64 bits of long double hold their partial sums (2^11 terms of 53 bits within one binade), so that its sum,
/// rounded, is the exact one rounded.
TEST(ExactSum, AgreesWithLongDouble) {
    static_assert(std::numeric_limits<long double>::digits >= 64);
    std::mt19937_64 bits(5);
    for (int trial = 0; trial < 50; ++trial) {
        ExactSum sum;
        long double reference = 0;
        for (int k = 0; k < 2000; ++k) {
            const double term = (trial % 2 == 0 ? 1 : -1) * (1.0 + static_cast<double>(bits() >> 12) * 0x1p-52);
            sum.add(term);
            reference += static_cast<long double>(term);
        }
        EXPECT_EQ(sum.value(), static_cast<double>(reference));
    }
}

TEST(ExactSum, ManyEqualTermsCarry) {
    ExactSum sum;
    for (int k = 0; k < 3'000'000; ++k) {
        sum.add(0x1.fffffffffffffp+31);
    }
    EXPECT_EQ(sum.value(), 3e6 * 0x1.fffffffffffffp+31); // a product of 53 and 22 bits, rounded once
}

TEST(ExactSum, WhatIsNotFiniteIsNeverLost) {
    const double inf = limits::infinity(), nan = limits::quiet_NaN();
    for (const double bad : {inf, -inf, nan}) {
        EXPECT_FALSE(std::isfinite(exact({1, bad, 2})));
    }
    EXPECT_FALSE(std::isfinite(exact({inf, -inf})));
    ExactSum sum;
    sum.add(nan);
    sum.clear();
    sum.add(2);
    EXPECT_EQ(sum.value(), 2) << "clear() forgets it";
    EXPECT_EQ(exact({limits::max(), limits::max()}), inf) << "a sum that no double holds";
}

} // namespace
} // namespace nappe
