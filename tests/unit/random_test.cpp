#include "core/random.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace nappe {
namespace {

constexpr auto radius_stream = RandomStream::deposit_radius;

double mean_of(std::uint64_t seed, int n) {
    double sum = 0;
    for (int k = 0; k < n; ++k) {
        sum += random_uniform(seed, radius_stream, static_cast<std::uint64_t>(k));
    }
    return sum / n;
}

// Computed apart, with integers of any length, from the formulas in mix.hpp and random.hpp. Stored samples rest on these
// digits: a change of the generator must be a new revision of the samples.
TEST(Random, IsTheSameOnEveryMachine) {
    EXPECT_EQ(random_bits(1, RandomStream::deposit_radius, 0), 0xc9eb520425e13097ULL);
    EXPECT_EQ(random_bits(1, RandomStream::deposit_radius, 1), 0x2ef239f9931f28e6ULL);
    EXPECT_EQ(random_bits(2, RandomStream::deposit_order, ~0ULL), 0x3f07463b922a2837ULL);
}

TEST(Random, DiffersInSeedStreamAndCounter) {
    std::set<std::uint64_t> seen;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        for (std::uint64_t counter = 0; counter < 500; ++counter) {
            seen.insert(random_bits(seed, RandomStream::deposit_radius, counter));
            seen.insert(random_bits(seed, RandomStream::deposit_order, counter));
        }
    }
    EXPECT_EQ(seen.size(), 20 * 500 * 2U);
}

TEST(Random, StaysBelowOneAndFillsTheInterval) {
    int in_bin[16] = {};
    constexpr int n = 160'000;
    for (std::uint64_t k = 0; k < n; ++k) {
        const double u = random_uniform(3, radius_stream, k);
        ASSERT_GE(u, 0);
        ASSERT_LT(u, 1);
        ++in_bin[static_cast<int>(16 * u)];
    }
    // Each bin is a binomial of mean 10,000 and deviation 97; 5 deviations.
    for (const int count : in_bin) {
        EXPECT_NEAR(count, 10'000, 485);
    }
}

// Over many seeds the mean must scatter as that of independent numbers does, neither more nor less: 200 squares of a
// unit normal have mean 1 and deviation 0.1; 4 deviations.
TEST(Random, MeansOfSeedsScatterAsIndependentNumbersDo) {
    constexpr int n = 2000;
    constexpr int seeds = 200;
    double sum = 0;
    for (int seed = 1; seed <= seeds; ++seed) {
        const double z = (mean_of(static_cast<std::uint64_t>(seed), n) - 0.5) * std::sqrt(12.0 * n);
        sum += z * z;
    }
    EXPECT_NEAR(sum / seeds, 1, 0.4);
}

// Neighbouring counters, and equal counters of neighbouring seeds, are uncorrelated: deviation 1 / sqrt(n), 5 of them.
TEST(Random, NeighboursAreUncorrelated) {
    constexpr std::uint64_t n = 40'000;
    double along = 0;
    double across = 0;
    for (std::uint64_t k = 0; k < n; ++k) {
        const double u = random_uniform(7, radius_stream, k) - 0.5;
        along += 12 * u * (random_uniform(7, radius_stream, k + 1) - 0.5);
        across += 12 * u * (random_uniform(8, radius_stream, k) - 0.5);
    }
    EXPECT_NEAR(along / n, 0, 0.025);
    EXPECT_NEAR(across / n, 0, 0.025);
}

} // namespace
} // namespace nappe
