// Gauges along walls: what a bin feels by formula, and that bins make up the wall, rigid and smooth, on any number of ranks.
#include "support/watched_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace nappe::test::gauges_test {
namespace {

constexpr double g = standard_gravity, r = 0.25;
const double m = 2800 * std::numbers::pi * r * r;

/// What gauges and walls felt since the start, of all ranks.
ContactSums<2> felt(const Communicator& comm, Simulation<2>& simulation) {
    auto sums = simulation.sums();
    sums.for_each_sum([&](ExactSum& s) { comm.sum(s.limbs()); });
    sums.gauges().for_each_sum([&](ExactSum& s) { comm.sum(s.limbs()); });
    return sums;
}

class Gauges : public WatchTest {};

Scene<2> heap(const SolverSettings& settings) {
    SceneBuilder b(0.4);
    b.box(12, 4, {RadiusLaw::Kind::uniform, 0.15, 0.25}, 5).grain(0.25, {6, 6}, {3, -4}, 20);
    b.stage(settings);
    for (auto& law : b.scene().laws) {
        law.springs = Springs{{2e6, 400}, {1e6, 200}};
    }
    auto scene = b.scene();
    scene.walls[0].points = {{0, 0}, {3, 0}, {12, 0}}; // a joint within a gauge
    scene.tiles.side = 1.5;
    scene.output.gauges = {{"floor", 0, 0, 12, 7, 0}, {"left", 1, 0, 8, 3, 0}, {"part", 0, 2, 5, 2, 0}};
    return scene;
}

/// Tolerance: bins and walls add the same impulses in other orders within a tile; exactly beyond. 1e-13 of all of them.
TEST_F(Gauges, BinsMakeUpTheWall) {
    for (const auto& settings : {solver(0.005, 20), smooth_settings(2e-4)}) {
        WatchedRun run(world, heap(settings)), one(alone, heap(settings));
        const int n = is_smooth(settings) ? 500 : 60;
        ASSERT_EQ(run.steps(n), "");
        ASSERT_EQ(one.steps(n), "");
        auto all = felt(world, run.simulation()), of_one = felt(alone, one.simulation());
        const auto whole = [&](std::size_t gauge, int bins) {
            GaugeImpulse sum;
            for (int bin = 0; bin < bins; ++bin) {
                const auto part = all.gauges().impulse(gauge, bin);
                sum.normal += part.normal;
                sum.tangential += part.tangential;
                EXPECT_EQ(part.normal, of_one.gauges().impulse(gauge, bin).normal) << "depends on ranks";
                EXPECT_EQ(part.tangential, of_one.gauges().impulse(gauge, bin).tangential);
                EXPECT_TRUE(gauge == 1 || part.normal > 0) << "nothing lies on it: the case is none";
            }
            return sum;
        };
        const Vec<2> floor = all.wall_impulse(0), left = all.wall_impulse(1);
        const double round = 1e-13 * floor.norm();
        EXPECT_NEAR(whole(0, 7).normal, -floor[1], round);
        EXPECT_NEAR(whole(0, 7).tangential, floor[0], round);
        EXPECT_NEAR(whole(1, 3).normal, -left[0], round); // it goes down: from its first point to its last
        EXPECT_NEAR(whole(1, 3).tangential, -left[1], round);
        EXPECT_NE(left[1], 0);
        EXPECT_LT(whole(2, 2).normal, 0.5 * -floor[1]);
    }
}

TEST_F(Gauges, ADiskAtRestWeighsOnItsBin) {
    for (const bool smooth : {false, true}) {
        SceneBuilder b(0.5);
        b.wall("floor", {{10, 0}, {0, 0}}).grain(r, {7.3, r}, {0, 0}).grain(r, {2.1, r}, {1, 0});
        b.stage(smooth ? smooth_settings(1e-4) : solver(0.01, 10));
        auto scene = b.scene();
        const double k = 4e6;
        for (auto& law : scene.laws) {
            law.springs = Springs{{k}, {k}};
        }
        for (auto& grain : scene.grains) {
            grain.position[1] -= smooth ? m * g / k : 0.0;
        }
        scene.output.gauges = {{"g", 0, 0, 10, 5, 0}};
        WatchedRun run(alone, scene);
        const int n = smooth ? 1000 : 10;
        const double t = 0.1, v0 = 1, mu = 0.5;
        ASSERT_EQ(run.steps(n), "");
        auto sums = felt(alone, run.simulation());
        for (int bin = 0; bin < 5; ++bin) { // the wall goes from right to left: 7.3 is 2.7 m along it, 2.1 is 7.9
            const double weights = bin == 1 || bin == 3 ? m * g * t : 0.0;
            EXPECT_NEAR(sums.gauges().impulse(0, bin).normal, weights, 1e-6 * m * g * t) << bin;
        }
        // It slides until t = v0 / (3 mu g), 0.068 s, and pushes the floor along, against the wall's direction: -m v0 / 3.
        EXPECT_NEAR(sums.gauges().impulse(0, 3).tangential, -m * v0 / 3, (smooth ? 1e-2 : 1e-9) * m * v0);
        EXPECT_GT(t, v0 / (3 * mu * g));
    }
}

/// Between two rows a disk strikes and is off again: the interval has its whole impulse.
TEST_F(Gauges, NoPeakIsLost) {
    const double e = 0.5, v0 = 3;
    SceneBuilder b(0, e);
    b.gravity(0, 0).floor(5).grain(r, {0, r + 0.1}, {0, -v0}).stage(solver(1e-3, 10));
    auto scene = b.scene();
    scene.output.gauges = {{"g", 0, 0, 10, 4, 0}};
    WatchedRun run(alone, scene);
    ASSERT_EQ(run.steps(100), "");
    auto sums = felt(alone, run.simulation());
    EXPECT_NEAR(sums.gauges().impulse(0, 2).normal, m * v0 * (1 + e), 1e-9 * m * v0);
    EXPECT_EQ(sums.gauges().impulse(0, 1).normal, 0);
}

/// A contact on a wall's first point counts to the first bin, one on its very end to the last, even if the gauge's end falls
/// short of it by what a sum of lengths is rounded by, one on a joint to the bin of the joint, by the segment before it.
TEST_F(Gauges, EndsBelongToTheLastBins) {
    const double first = std::hypot(0.7, 0.1), length = first + std::hypot(0.3, 0.1), v0 = 1;
    for (const double end : {length, length * (1 - 1e-12)}) {
        SceneBuilder b(0);
        b.wall("peg", {{0, 0}, {0.7, 0.1}, {1, 0}}).grain(r, {-0.2, 0.1}, {1, 0}).grain(r, {1.2, 0.1}, {-1, 0});
        b.grain(r, {0.7, 0.1 + r + 0.01}, {0, -v0}); // on the joint, 0.707 m along the wall
        b.gravity(0, 0).stage(solver(0.01, 10));
        auto scene = b.scene();
        scene.output.gauges = {{"g", 0, 0, end, 4, 0}}; // of 0.256 m
        WatchedRun run(alone, scene);
        ASSERT_EQ(run.steps(5), "");
        auto sums = felt(alone, run.simulation());
        EXPECT_NE(sums.gauges().impulse(0, 0).tangential, 0);
        EXPECT_EQ(sums.gauges().impulse(0, 1).tangential, 0);
        EXPECT_NEAR(sums.gauges().impulse(0, 2).normal, m * v0 * 0.7 / first, 1e-9 * m * v0);
        EXPECT_NEAR(sums.gauges().impulse(0, 2).tangential, -m * v0 * 0.1 / first, 1e-9 * m * v0);
        EXPECT_NE(sums.gauges().impulse(0, 3).tangential, 0) << end / length - 1;
    }
}

} // namespace
} // namespace nappe::test::gauges_test
