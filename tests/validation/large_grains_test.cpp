// Grains that tiles are not made for obey the same mechanics as the others.
#include "support/serial_run.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace nappe::test::large_grains_test {
namespace {

constexpr double g = standard_gravity;
constexpr double ulp = std::numeric_limits<double>::epsilon();
constexpr double small = 0.05, big = 0.6;

/// Rows of small disks between two columns, just touching, and two big ones coming down on them, one of them close to a
/// wall.
SceneBuilder rocks_on_a_bed(double friction) {
    SceneBuilder b(friction);
    constexpr int columns = 30, rows = 4;
    b.wall("box", {{0, 8}, {0, 0}, {2 * small * columns, 0}, {2 * small * columns, 8}});
    for (int k = 0; k < rows; ++k) {
        for (int j = 0; j < columns; ++j) {
            b.grain(small, {(2 * j + 1) * small, (2 * k + 1) * small});
        }
    }
    b.grain(big, {big, 2 * small * rows + big}, {-0.5, -3})
        .grain(big, {2.001 * big + big, 2 * small * rows + big}, {-1.5, -4});
    b.scene().tiles.side = 20 * small;
    return b;
}

Scene<2> smooth_scene(double large_above) {
    auto b = rocks_on_a_bed(0.4);
    for (auto& law : b.scene().laws) {
        law.springs = Springs{{4e6}, {4e6}};
    }
    b.stage(smooth_settings(2e-5));
    b.scene().tiles.large_above = large_above;
    return b.scene();
}

TEST(LargeGrains, AreMovedBySmoothContactsLikeTheOthers) {
    // Forces of a grain are added up in another order, nothing else differs; 400 steps at 0.06 of an oscillation each, in
    // which a difference of one ulp has no time to grow by more than a few orders.
    auto tiled = smooth_scene(0);
    tiled.tiles.side = 20 * big;
    SerialRun one(tiled), other(smooth_scene(2 * small));
    ASSERT_FALSE(one.simulation().candidates().has_large());
    ASSERT_TRUE(other.simulation().candidates().has_large());
    one.steps(400);
    other.steps(400);
    const auto rows = one.simulation().grain_rows();
    double moved = 0;
    for (const auto& row : rows) {
        const auto same = other.grain(row.id);
        for (int d = 0; d < 2; ++d) {
            EXPECT_NEAR(row.x[d], same.x[d], 1e6 * ulp * big) << row.id;
            EXPECT_NEAR(row.v[d], same.v[d], 1e6 * ulp * 2) << row.id;
            moved = std::max(moved, std::abs(row.v[d]));
        }
        EXPECT_NEAR(row.spin[0], same.spin[0], 1e6 * ulp * 2 / small) << row.id;
    }
    EXPECT_GT(moved, 1) << "nothing happened";
    const auto contacts = other.loaded_contacts();
    const auto of = [&](GlobalId lo, GlobalId hi) {
        return std::any_of(contacts.begin(), contacts.end(), [&](const auto& c) { return c.lo == lo && c.hi == hi; });
    };
    EXPECT_TRUE(of(120, 121)) << "the two rocks do not touch: the case is too easy";
    EXPECT_GE(std::count_if(contacts.begin(), contacts.end(), [](const auto& c) { return c.hi == 121; }), 3);
    EXPECT_TRUE(
        std::any_of(contacts.begin(), contacts.end(), [](const auto& c) { return c.lo == 120 && c.wall >= 0; }));
}

TEST(LargeGrains, KeepMomentumInCollisionsWithMany) {
    // Without gravity and walls nothing comes from outside, whatever the number of sweeps.
    for (const bool smooth : {false, true}) {
        SceneBuilder b(0.5);
        b.gravity(0, 0);
        for (int k = 0; k < 9; ++k) {
            for (int j = 0; j < 9; ++j) {
                b.grain(small, {2.0 * j * small, 2.0 * k * small});
            }
        }
        b.grain(big, {0.3, -big - 0.9 * small}, {0.1, 3}, 2);
        b.scene().tiles.side = 20 * small;
        b.scene().tiles.large_above = 2 * small;
        for (auto& law : b.scene().laws) {
            law.springs = Springs{{4e6}, {4e6}};
        }
        SerialRun run(b.stage(smooth ? smooth_settings(2e-5) : solver(1e-3, 7)).scene());
        ASSERT_TRUE(run.simulation().candidates().has_large());
        const auto momentum = [&] {
            Vec<2> sum = Vec<2>::Zero();
            double about = 0; // the origin
            for (const auto& row : run.simulation().grain_rows()) {
                sum += row.mass * Vec<2>(row.v[0], row.v[1]);
                about += row.mass *
                         (row.x[0] * row.v[1] - row.x[1] * row.v[0] + 0.5 * row.radius * row.radius * row.spin[0]);
            }
            return std::pair(sum, about);
        };
        const auto before = momentum();
        const double p = before.first.norm();
        run.steps(smooth ? 400 : 30);
        const auto after = momentum();
        EXPECT_LT(run.grain(81).v[1], 2.99) << "nothing was hit";
        // Round-off of so many steps and contacts.
        EXPECT_NEAR((after.first - before.first).norm(), 0, 1e5 * ulp * p) << smooth;
        // Impulses act where radii end, not in one point: of an overlap or gap so much is missing, with the tangential
        // impulse that is below mu p.
        const double overlap = 0.5 * small;
        EXPECT_NEAR(after.second, before.second, 0.5 * p * overlap) << smooth;
    }
}

TEST(LargeGrains, AreMovedByTheContactsThatAreReported) {
    // m (v - v_before) = h m g + sum of impulses in any step and after any number of sweeps, but for normals: those
    // reported are of the step's end, those it went by of its middle. They turn by less than the fastest way in a step
    // over the distance of the centres.
    auto b = rocks_on_a_bed(0.3);
    b.scene().tiles.large_above = 2 * small;
    constexpr double h = 2e-3, fastest = 4.2, turned = fastest * h / (big + small);
    SerialRun run(b.stage(solver(h, 20)).scene());
    std::array<int, 2> most{};
    for (int step = 0; step < 200; ++step) {
        const std::array<GrainRow<2>, 2> before{run.grain(120), run.grain(121)};
        run.steps(1);
        const auto contacts = run.loaded_contacts();
        for (std::size_t k = 0; k < 2; ++k) {
            const auto& rock = before[k];
            Vec<2> sum = h * rock.mass * Vec<2>(0, -g);
            double pressed = 0;
            int n = 0;
            for (const auto& c : contacts) {
                if (c.lo == rock.id || c.hi == rock.id) { // normals go from hi to lo
                    const double sign = c.lo == rock.id ? 1 : -1;
                    sum += sign * Vec<2>(c.r_n * c.normal[0] - c.r_t[0] * c.normal[1],
                                         c.r_n * c.normal[1] + c.r_t[0] * c.normal[0]);
                    pressed += c.r_n;
                    ++n;
                }
            }
            most[k] = std::max(most[k], n);
            const auto after = run.grain(rock.id);
            for (int d = 0; d < 2; ++d) {
                EXPECT_NEAR(rock.mass * (after.v[d] - rock.v[d]), sum[d], turned * pressed + 1e4 * ulp * rock.mass)
                    << rock.id << " " << step;
            }
        }
    }
    EXPECT_GE(std::min(most[0], most[1]), 4) << "the case is too easy";
}

} // namespace
} // namespace nappe::test::large_grains_test
