// The sample of nappe bench: mirrored copies of a settled block.

#include "commands/bench_sample.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

namespace nappe {
namespace {

/// About 300 disks; settled so far that its own motion tells what `at rest` means below.
const SettledBlock& block() {
    static const SettledBlock settled = settle_block(Communicator::alone(), 300, 150);
    return settled;
}

double largest_speed(const Simulation<2>& simulation) {
    double largest = 0;
    for (const auto& row : simulation.grain_rows()) {
        largest = std::max(largest, std::hypot(row.v[0], row.v[1]));
    }
    return largest;
}

TEST(BenchSample, CopiesHaveIdsInARowAndStandSideBySide) {
    const auto n = static_cast<GlobalId>(block().grains.size());
    EXPECT_NEAR(static_cast<double>(n), 300, 30);
    const auto sample = repeat_block(block(), 0, 3, 3);
    ASSERT_EQ(sample.grains.size(), static_cast<std::size_t>(3 * n));
    for (GlobalId id = 0; id < 3 * n; ++id) {
        const auto& row = sample.grains[static_cast<std::size_t>(id)];
        const auto& original = block().grains[static_cast<std::size_t>(id % n)];
        EXPECT_EQ(row.id, id);
        EXPECT_EQ(row.radius, original.radius);
        EXPECT_EQ(row.x[1], original.x[1]);
        const double left = static_cast<double>(id / n) * block().length;
        EXPECT_GT(row.x[0], left);
        EXPECT_LT(row.x[0], left + block().length);
    }
}

TEST(BenchSample, SharesOfRanksMakeTheWhole) {
    const auto whole = repeat_block(block(), 0, 4, 4);
    auto parts = repeat_block(block(), 0, 1, 4);
    const auto rest = repeat_block(block(), 1, 4, 4);
    parts.grains.insert(parts.grains.end(), rest.grains.begin(), rest.grains.end());
    parts.impulses.insert(parts.impulses.end(), rest.impulses.begin(), rest.impulses.end());
    ASSERT_EQ(parts.grains.size(), whole.grains.size());
    ASSERT_EQ(parts.impulses.size(), whole.impulses.size());
    std::set<std::pair<GlobalId, GlobalId>> names;
    for (std::size_t k = 0; k < whole.impulses.size(); ++k) {
        EXPECT_EQ(parts.impulses[k].lo, whole.impulses[k].lo);
        EXPECT_EQ(parts.impulses[k].hi, whole.impulses[k].hi);
        EXPECT_LT(whole.impulses[k].lo, whole.impulses[k].hi);
        names.insert({whole.impulses[k].lo, whole.impulses[k].hi});
    }
    EXPECT_EQ(names.size(), whole.impulses.size()) << "a contact was given twice";
}

/// A grain that leant on a wall leans on its image: no speed beyond what the block itself still has after as many
/// steps.
/// (Copies that are not mirrored fall into each other's gaps at some 0.1 m/s.)
TEST(BenchSample, CopiesAreAtRestAsTheBlockIs) {
    const auto alone = Communicator::alone();
    const auto speed_of = [&](std::int64_t copies) {
        Simulation<2> simulation(alone, bench_scene(static_cast<double>(copies) * block().length), disk_kernels());
        load_copies(simulation, block(), copies);
        for (int k = 0; k < 3; ++k) {
            simulation.step();
        }
        return largest_speed(simulation);
    };
    const double one = speed_of(1);
    EXPECT_LT(one, 0.02) << "the block is not settled: gravity gives 0.25 m/s in a step";
    EXPECT_LT(speed_of(3), 2 * one + 0.005);
}

TEST(BenchSample, SizesAreWholeCopies) {
    const auto n = static_cast<std::int64_t>(block().grains.size());
    EXPECT_EQ(n_copies(block(), 1), 1);
    EXPECT_EQ(n_copies(block(), 10 * n), 10);
    EXPECT_EQ(n_copies(block(), 10 * n + n / 3), 10);
    EXPECT_EQ(n_copies(block(), 11 * n - n / 3), 11);
}

} // namespace
} // namespace nappe
