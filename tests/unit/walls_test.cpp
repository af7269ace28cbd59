// Walls taken apart into features: which one a grain touches, on which side, and when it went through.

#include "core/walls.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace nappe {
namespace {

Wall<2> wall_of(std::vector<Vec<2>> points) {
    Wall<2> wall;
    wall.name = "wall";
    wall.points = std::move(points);
    return wall;
}

double distance_to(const std::vector<Vec<2>>& points, const Vec<2>& x) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k + 1 < points.size(); ++k) {
        const Vec<2> along = points[k + 1] - points[k];
        const double s = std::min(1.0, std::max(0.0, (x - points[k]).dot(along) / along.squaredNorm()));
        least = std::min(least, (x - (points[k] + s * along)).norm());
    }
    return least;
}

struct Touched {
    int n = 0;                                                 ///< features that apply
    double distance = std::numeric_limits<double>::infinity(); ///< of the nearest of them
    Vec<2> n_vector = Vec<2>::Zero();                          ///< its normal
};

Touched touched(const Walls<2>& walls, const Vec<2>& x) {
    Touched t;
    for (int f = 0; f < walls.n_features(); ++f) {
        const auto c = walls.contact(walls.side_of(f, x), x, 0.5);
        if (c.applies) {
            ++t.n;
            if (c.distance < t.distance) {
                t.distance = c.distance;
                t.n_vector = c.n;
            }
        }
    }
    return t;
}

TEST(Walls, AreTakenApart) {
    const Walls<2> open({wall_of({{0, 0}, {1, 0}, {1, 2}}), wall_of({{5, 5}, {6, 5}})});
    EXPECT_EQ(open.n_walls(), 2);
    EXPECT_EQ(open.n_features(), 2 + 3 + 1 + 2);
    EXPECT_EQ(open.n_bodies(), 2 * open.n_features());
    const Walls<2> closed({wall_of({{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}})});
    EXPECT_EQ(closed.n_features(), 4 + 4) << "the point that closes it counts once";
    for (int f = 0; f < closed.n_features(); ++f) {
        const auto& feature = closed.feature(2 * f);
        EXPECT_TRUE(!feature.is_point || (feature.has_before && feature.has_after)) << "a closed wall has no end";
    }
}

/// The nearest feature that applies is the nearest part of the wall, anywhere around it.
TEST(Walls, NearestFeatureIsTheNearestPart) {
    std::mt19937_64 bits(1);
    std::uniform_real_distribution<double> somewhere(-3, 3);
    for (int trial = 0; trial < 200; ++trial) {
        std::vector<Vec<2>> points;
        for (int k = 0; k < 3 + trial % 3; ++k) {
            points.push_back({somewhere(bits), somewhere(bits)});
        }
        if (trial % 4 == 0) {
            points.push_back(points.front());
        }
        const Walls<2> walls({wall_of(points)});
        for (int k = 0; k < 50; ++k) {
            const Vec<2> x(somewhere(bits), somewhere(bits));
            const auto t = touched(walls, x);
            EXPECT_NEAR(t.distance, distance_to(points, x), 1e-12) << "round-off of coordinates up to 3";
            EXPECT_NEAR(distance_to(points, x - t.distance * t.n_vector), 0, 1e-12) << "the normal points to the wall";
        }
    }
}

/// Straight above a joint round-off must not open a gap between the features: for every last bit of the position exactly one of them
/// applies on the outside of a bend, and at least one along a straight run.
TEST(Walls, NoGapAboveAJoint) {
    std::mt19937_64 bits(2);
    std::uniform_real_distribution<double> somewhere(-3, 3);
    int straight = 0;
    for (int trial = 0; trial < 2000; ++trial) {
        const Vec<2> joint(somewhere(bits), somewhere(bits));
        const Vec<2> along = Vec<2>(somewhere(bits), somewhere(bits)).normalized();
        const Vec<2> up(-along[1], along[0]);
        const double bend = trial % 2 == 0 ? 0.0 : 1e-3 * std::abs(somewhere(bits)); // downwards: the outside is above
        const Vec<2> after = std::cos(bend) * along - std::sin(bend) * up;
        const Walls<2> walls({wall_of({joint - 1.7 * along, joint, joint + 2.3 * after})});
        Vec<2> x = joint + 0.4 * up;
        for (int k = 0; k < 8; ++k) {
            x[0] = std::nextafter(x[0], x[0] - along[0]);
        }
        for (int k = 0; k < 16; ++k) {
            const auto t = touched(walls, x);
            ASSERT_GE(t.n, 1) << "trial " << trial << " bit " << k;
            ASSERT_NEAR(t.distance, 0.4, 1e-14);
            if (bend > 1e-6) {
                ASSERT_EQ(t.n, 1) << "trial " << trial << " bit " << k;
            }
            straight += bend == 0;
            x[0] = std::nextafter(x[0], x[0] + along[0]);
        }
    }
    EXPECT_GT(straight, 0);
}

TEST(Walls, SidesAreToldApartAndCrossingIsSeen) {
    const Walls<2> walls({wall_of({{0, 0}, {10, 0}})});
    const int above = walls.side_of(0, {5, 1}), below = walls.side_of(0, {5, -1});
    EXPECT_NE(above, below);
    EXPECT_EQ(above / 2, 0);
    EXPECT_EQ(below / 2, 0);
    const double r = 0.5;
    EXPECT_FALSE(walls.contact(above, {5, 0.4}, r).through);
    EXPECT_EQ(walls.contact(above, {5, 0.4}, r).n, (Vec<2>(0, 1)));
    EXPECT_TRUE(walls.contact(above, {5, -0.1}, r).through);
    EXPECT_FALSE(walls.contact(below, {5, -0.1}, r).through);
    EXPECT_EQ(walls.contact(below, {5, -0.1}, r).n, (Vec<2>(0, -1)));
    EXPECT_FALSE(walls.contact(above, {11, -0.1}, r).through) << "beyond the end";
    EXPECT_FALSE(walls.contact(above, {5, -0.6}, r).through) << "came round the end";
}

/// A straight way through the segment counts, however far it goes; one past its end, to it, from it or along it does not.
TEST(Walls, FastWaysThroughASegmentAreSeen) {
    Walls<2> walls({wall_of({{0, 0}, {10, 0}})});
    const int above = walls.side_of(0, {5, 1}), below = walls.side_of(0, {5, -1});
    const auto went = [&](int sided, const Vec<2>& from, const Vec<2>& to) {
        return walls.crossed(sided, to, to - from);
    };
    EXPECT_TRUE(went(above, {5, 0.5}, {5, -0.1}));
    EXPECT_TRUE(went(above, {5, 0.5}, {5, -500}));
    EXPECT_TRUE(went(above, {-1, 1}, {3, -1})) << "between its ends: (1, 0)";
    EXPECT_FALSE(went(above, {-3, 1}, {1, -1})) << "past its end: (-1, 0)";
    EXPECT_FALSE(went(above, {9, 1}, {13, -1})) << "past its end: (11, 0)";
    EXPECT_FALSE(went(above, {5, 2}, {5, 0.1}));
    EXPECT_FALSE(went(above, {5, -1}, {5, 2})) << "comes back";
    EXPECT_FALSE(went(above, {2, 0.5}, {8, 0.5}));
    EXPECT_TRUE(went(below, {5, -0.5}, {5, 20}));
    EXPECT_FALSE(went(below, {5, 0.5}, {5, -20}));
    walls.offset_mid[0] = {0, 3};
    EXPECT_TRUE(went(above, {5, 4}, {5, 2.9})) << "where the wall is now";
    EXPECT_FALSE(went(above, {5, 4}, {5, 3.1}));
    const int point = walls.side_of(1, {5, 1});
    EXPECT_FALSE(went(point, {0, 4}, {0, 2})) << "points have no sides";
}

TEST(Walls, MoveWithTheirOffsets) {
    Walls<2> walls({wall_of({{0, 0}, {10, 0}})});
    walls.offset[0] = {1, 2};
    walls.offset_mid[0] = {1, 2.5};
    walls.offset_ref[0] = {1, 1};
    EXPECT_EQ(walls.points(0)[1], (Vec<2>(11, 2)));
    EXPECT_DOUBLE_EQ(walls.contact(0, {5, 3}, 0.5).distance, 0.5);
    EXPECT_DOUBLE_EQ(walls.distance_ref(0, {5, 3}), 2);
    EXPECT_DOUBLE_EQ(walls.distance_ref(0, {14, 5}), 5) << "3 beyond the end, 4 above it";
    EXPECT_NE(walls.side_of(0, {5, 0.9}), walls.side_of(0, {5, 1.1}));
}

TEST(Walls, DrivenVelocity) {
    Wall<2> wall = wall_of({{0, 0}, {1, 0}});
    const Vec<2> still(0, 0), moving(2, 0);
    EXPECT_EQ(driven_velocity(wall, 3, false, 0, 1), still);
    Motion<2> motion;
    motion.velocity = moving;
    motion.stage = 1;
    wall.motion = motion;
    EXPECT_EQ(driven_velocity(wall, 0, false, 5, 6), still);
    EXPECT_EQ(driven_velocity(wall, 1, false, 0, 1), moving);
    EXPECT_EQ(driven_velocity(wall, 2, false, 0, 1), moving);
    wall.motion->stop = 3;
    EXPECT_EQ(driven_velocity(wall, 1, false, 2, 3), moving);
    EXPECT_EQ(driven_velocity(wall, 1, false, 3, 4), still);
    wall.motion->stage = -1;
    wall.motion->start = 1;
    EXPECT_EQ(driven_velocity(wall, 0, false, 0, 1), still);
    EXPECT_EQ(driven_velocity(wall, 0, false, 1, 2), moving);
    EXPECT_EQ(driven_velocity(wall, 0, true, 1, 2), still) << "loading time stands still while preparing";
    // Times are sums of steps: a few last bits must not cost or add a step.
    EXPECT_EQ(driven_velocity(wall, 0, false, 1 - 1e-12, 2 - 1e-12), moving);
    EXPECT_EQ(driven_velocity(wall, 0, false, 3 - 1e-12, 4 - 1e-12), still);
}

} // namespace
} // namespace nappe
