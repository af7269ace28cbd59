// Grains that come through each other or through a wall, found along their way.

#include "core/neighbours.hpp"
#include "core/passage.hpp"

#include <gtest/gtest.h>

namespace nappe {
namespace {

constexpr double seconds = 0.1;

/// Disks that have moved for `seconds` in a straight line to where they are; a floor under them.
struct Moved {
    struct Disk {
        double x, y, radius, vx, vy; ///< at the end of the way
    };

    explicit Moved(const std::vector<Disk>& disks) : walls({floor()}) {
        std::vector<GrainRecord<2>> grains;
        for (const auto& disk : disks) {
            GrainRecord<2> g;
            g.id = static_cast<GlobalId>(grains.size());
            g.x = {disk.x, disk.y};
            g.u.v = {disk.vx, disk.vy};
            g.radius = disk.radius;
            g.mass = 1;
            g.u.inv_m = 1;
            g.margin = 5;
            grains.push_back(g);
        }
        state.assign(grains, {}, walls.n_bodies());
        state.u_old = state.u;
        find_candidates(state, TileGrid<2>({-50, -50}, 100), walls, {}, candidates);
    }

    static Wall<2> floor() { return {"floor", 0, {{-40, 0}, {40, 0}}, {}}; }

    Passage between_grains(bool all = true) const { return find_passage(state, candidates, seconds, all); }

    Walls<2> walls;
    State<2> state;
    CandidateSet<2> candidates;
};

TEST(Passage, TouchingAndOverlappingIsNone) {
    EXPECT_EQ(Moved({{0, 5, 1, 0, 0}, {2, 5, 1, 0, 0}}).between_grains().lo, Passage::none);
    EXPECT_EQ(Moved({{0, 5, 1, 0, 0}, {1.01, 5, 1, 0, 0}}).between_grains().lo, Passage::none);
}

TEST(Passage, CentreWithinTheOther) {
    EXPECT_EQ(Moved({{0, 5, 1, 0, 0}, {0.99, 5, 1, 0, 0}}).between_grains().lo, 0);
    // Of the larger, of course: the small one is all inside.
    EXPECT_EQ(Moved({{0, 5, 0.1, 0, 0}, {0.95, 5, 1, 0, 0}}).between_grains().hi, 1);
    EXPECT_EQ(Moved({{0, 5, 0.1, 0, 0}, {1.05, 5, 1, 0, 0}}).between_grains().lo, Passage::none);
}

TEST(Passage, AlongTheWay) {
    // From x = -3 to 3 over a disk at 0: through it at height 0, past it at height 1.1.
    EXPECT_EQ(Moved({{3, 5, 1, 60, 0}, {0, 5, 1, 0, 0}}).between_grains().lo, 0);
    EXPECT_EQ(Moved({{3, 6.1, 1, 60, 0}, {0, 5, 1, 0, 0}}).between_grains().lo, Passage::none);
    // The same seen from the other, and both moving.
    EXPECT_EQ(Moved({{0, 5, 1, 0, 0}, {3, 5, 1, 60, 0}}).between_grains().lo, 0);
    EXPECT_EQ(Moved({{1.5, 5, 1, 30, 0}, {-1.5, 5, 1, -30, 0}}).between_grains().lo, 0);
    // Side by side at any speed; on the way towards each other, not there yet.
    EXPECT_EQ(Moved({{3, 5, 1, 60, 0}, {3, 7, 1, 60, 0}}).between_grains().lo, Passage::none);
    EXPECT_EQ(Moved({{-2, 5, 1, 60, 0}, {0, 5, 1, 0, 0}}).between_grains().lo, Passage::none);
}

TEST(Passage, SlowPairsOnlyWhenAllAreLookedAt) {
    const double slow = 0.9 * slow_stride / seconds, fast = 1.1 * slow_stride / seconds;
    const auto deep = [](double v) { return Moved({{0, 5, 1, v, 0}, {0.5, 5, 1, 0, 0}}); };
    EXPECT_EQ(deep(slow).between_grains(false).lo, Passage::none);
    EXPECT_EQ(deep(slow).between_grains(true).lo, 0);
    EXPECT_EQ(deep(fast).between_grains(false).lo, 0);
    EXPECT_EQ(Moved({{0, 5, 1, 0, 0}, {0.5, 5, 1, fast, 0}}).between_grains(false).lo, 0);
}

TEST(Passage, FirstByIds) {
    const Passage found =
        Moved({{0, 5, 1, 0, 0}, {8, 5, 1, 0, 0}, {8.5, 5, 1, 0, 0}, {8.1, 5.1, 1, 0, 0}}).between_grains();
    EXPECT_EQ(found.lo, 1);
    EXPECT_EQ(found.hi, 2);
    EXPECT_EQ(found.wall, -1);
}

TEST(Passage, ThroughAWallInTheRestOfTheStep) {
    const std::vector<std::size_t> tiles = {0};
    const auto falls = [&](double height, double speed) {
        const Moved m({{-20, 5, 1, 0, 0}, {1, height, 1, 0, -speed}});
        return find_wall_passage<2>(m.state, m.candidates, m.walls, tiles, seconds);
    };
    EXPECT_EQ(falls(1, 9).lo, Passage::none); // to 0.1 m above it
    EXPECT_EQ(falls(1, 11).lo, 1);            // to 0.1 m below
    EXPECT_EQ(falls(1, 11).wall, 0);
    EXPECT_EQ(falls(1, -11).lo, Passage::none);
    EXPECT_EQ(find_wall_passage<2>(Moved({{1, 1, 1, 0, -11}}).state, Moved({{1, 1, 1, 0, -11}}).candidates,
                                   Walls<2>({Moved::floor()}), {}, seconds)
                  .lo,
              Passage::none)
        << "of no tile";
    // Beside the floor's end there is nothing to go through.
    const Moved beside({{40.5, 0.3, 1, 0, -10}});
    EXPECT_EQ(find_wall_passage<2>(beside.state, beside.candidates, beside.walls, tiles, seconds).lo, Passage::none);
}

} // namespace
} // namespace nappe
