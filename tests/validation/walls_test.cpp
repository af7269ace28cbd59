// Walls as grains meet them: joints, corners and ends are touched once, nothing gets through, moving walls push at their speed.

#include "core/error.hpp"
#include "support/serial_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

namespace nappe::test::walls_test {
namespace {

constexpr double g = standard_gravity;

/// A floor in many collinear pieces, along a direction that no double represents, is as smooth as one piece: the disk keeps its
/// speed, its height and one contact at every step, also where its centre is over a joint to the last bit or nearly.
TEST(WallJoint, CollinearPiecesAreOneFloor) {
    const double r = 0.4, h = 1e-2, v0 = 1;
    const Vec<2> along = Vec<2>(7, 1) / std::sqrt(50.0);
    const Vec<2> up(-along[1], along[0]);
    std::vector<Vec<2>> points;
    for (int k = 0; k <= 60; ++k) {
        points.push_back((k * 0.1) * along); // a step of 0.01 m meets the joints every tenth time
    }
    SceneBuilder b(0.4);
    b.gravity(-g * up[0], -g * up[1]).wall("floor", points).grain(r, along + r * up, v0 * along, -v0 / r);
    b.stage(solver(h, 3));
    SerialRun run(b.scene());
    for (int n = 0; n < 400; ++n) {
        run.steps(1);
        const auto grain = run.grain(0);
        const Vec<2> v(grain.v[0], grain.v[1]), x(grain.x[0], grain.x[1]);
        // Round-off of positions (1e-15 m) over h, and its normals: 1e-12 m/s.
        ASSERT_EQ(run.loaded_contacts().size(), 1u) << "step " << n;
        ASSERT_NEAR(v.dot(along), v0, 1e-11) << "step " << n;
        ASSERT_NEAR(v.dot(up), 0, 1e-11) << "step " << n;
        ASSERT_NEAR(x.dot(up), r, 1e-11) << "step " << n;
    }
}

/// In a valley the disk touches both segments and not the point between them; on a ridge and beyond an end, the point alone.
TEST(WallJoint, ConcaveConvexAndEnd) {
    const double r = 0.5, h = 1e-2, a = 0.3;
    const struct {
        const char* what;
        std::vector<Vec<2>> points;
        Vec<2> centre;
        std::size_t n_contacts;
        Vec<2> normal; ///< of the first
    } cases[] = {
        {"valley",
         {{-9, 9 * std::tan(a)}, {0, 0}, {9, 9 * std::tan(a)}},
         {0, r / std::cos(a)},
         2,
         {std::sin(a), std::cos(a)}},
        {"ridge", {{-9, -9 * std::tan(a)}, {0, 0}, {9, -9 * std::tan(a)}}, {0, r}, 1, {0, 1}},
        {"ridge, off its middle",
         {{-9, -9 * std::tan(a)}, {0, 0}, {9, -9 * std::tan(a)}},
         {r * std::sin(0.1), r * std::cos(0.1)},
         1,
         {std::sin(0.1), std::cos(0.1)}},
        {"end", {{-9, 0}, {0, 0}}, {r * std::sin(0.2), r * std::cos(0.2)}, 1, {std::sin(0.2), std::cos(0.2)}},
        {"joint of a flat floor", {{-9, 0}, {0, 0}, {9, 0}}, {0, r}, 1, {0, 1}},
        {"start of a wall", {{0, 0}, {9, 0}}, {0, r}, 1, {0, 1}},
    };
    for (const auto& c : cases) {
        SceneBuilder b(0.4);
        b.wall("it", c.points).grain(r, c.centre).stage(solver(h, 50));
        SerialRun run(b.scene());
        run.steps(1);
        const auto contacts = run.loaded_contacts();
        ASSERT_EQ(contacts.size(), c.n_contacts) << c.what;
        EXPECT_NEAR(contacts[0].normal[0], c.normal[0], 1e-3)
            << c.what; // the step has moved it by less than g h² = 1e-3 m
        EXPECT_NEAR(contacts[0].normal[1], c.normal[1], 1e-3) << c.what;
    }
}

/// A disk rolls over the edge of a table without slip, slowly. It turns about the edge: (3/4) m v² = (3/4) m v0² + m g r (1 - cos phi).
/// It leaves where the edge no longer presses, m v² / r = m g cos phi: cos phi = 4/7 + 3 v0² / (7 g r). The normal turns with the disk.
TEST(WallJoint, RollsOverAnEdgeAndLeavesIt) {
    const double r = 0.5, v0 = 0.3, h = 1e-3;
    for (const bool corner : {false, true}) { // a table's corner, or just the end of a plate
        std::vector<Vec<2>> points = {{-5, 0}, {0, 0}};
        if (corner) {
            points.push_back({0, -5});
        }
        SceneBuilder b(5.0);
        b.wall("table", points).grain(r, {-0.05, r}, {v0, 0}, -v0 / r).stage(solver(h, 20));
        SerialRun run(b.scene());
        double angle = 0;
        int in_air = 0;
        for (int n = 0; n < 2000 && in_air < 20; ++n) {
            run.steps(1);
            const auto contacts = run.loaded_contacts();
            ASSERT_LE(contacts.size(), 1u);
            in_air = contacts.empty() ? in_air + 1 : 0;
            if (!contacts.empty()) {
                const double now = std::atan2(contacts[0].normal[0], contacts[0].normal[1]);
                // No jump: in a step the normal turns by at most h v / r, v < 2 m/s.
                ASSERT_LE(std::abs(now - angle), h * 2 / r) << "step " << n;
                angle = now;
            }
        }
        EXPECT_EQ(in_air, 20) << "never left";
        const double cosine = 4.0 / 7 + 3 * v0 * v0 / (7 * g * r);
        // Order 1 in h: forces at the edge vanish slowly, m g cos phi - m v²/r falls by 2.3 m g sin phi per radian, and a step of 1e-3 s
        // shifts the energy by h v0 … 3e-3 rad; take ten times that.
        EXPECT_NEAR(angle, std::acos(cosine), 0.03) << (corner ? "corner" : "end");
    }
}

/// Throws a disk at a wall; whether the run ends in a NumericalFailure that names it, or else it is still on its side.
void expect_not_through(const Scene<2>& scene, const std::string& what) {
    SerialRun run(scene);
    const double side = run.grain(0).x[1];
    ASSERT_GT(side, 0);
    try {
        for (int n = 0; n < 50; ++n) {
            run.steps(1);
            ASSERT_GE(run.grain(0).x[1], -1e-12) << what << ": went through without a word in step " << n;
        }
    } catch (const NumericalFailure& failure) {
        EXPECT_NE(std::string(failure.what()).find("grain 0 "), std::string::npos) << failure.what();
    }
}

/// At any speed, from any distance, in tiles small and large, onto the middle of a segment and onto joints of all kinds.
TEST(Tunnelling, NoSpeedGetsThroughAWall) {
    const double r = 0.5;
    const std::vector<Vec<2>> walls[] = {
        {{-1000, 0}, {1000, 0}},
        {{-1000, 0}, {0, 0}, {1000, 0}},
        {{-1000, 0}, {-1, 0}, {1, 0}, {1000, 0}},
    };
    for (const double tile : {0.0, 100.0}) {
        for (const double speed : {1.0, 30.0, 100.0, 150.0, 250.0, 400.0, 1000.0, 3000.0, 1e5}) {
            for (const double gap : {0.0, 0.013, 0.3, 1.0, 4.0, 20.0}) {
                for (const double slant : {0.0, 0.7}) {
                    for (const auto& points : walls) {
                        SceneBuilder b(0.4);
                        b.wall("floor", points).grain(r, {0, r + gap}, {slant * speed, -speed}).stage(solver(1e-2, 5));
                        b.scene().tiles.side = tile;
                        expect_not_through(b.scene(), "speed " + std::to_string(speed) + ", gap " +
                                                          std::to_string(gap) + ", slant " + std::to_string(slant) +
                                                          ", tile " + std::to_string(tile) + ", points " +
                                                          std::to_string(points.size()));
                    }
                }
            }
        }
    }
}

/// The same with the parts exchanged: a wall comes down on a resting disk, faster than any disk may move.
TEST(Tunnelling, NoDiskGetsThroughAMovingWall) {
    for (const double speed : {1.0, 30.0, 100.0, 250.0, 1000.0, 1e5}) {
        for (const double gap : {0.0, 0.013, 0.3, 4.0}) {
            Motion<2> motion;
            motion.velocity = {speed, 0};
            motion.start = 0.02;
            SceneBuilder b(0.4);
            b.floor(1e4)
                .moving_wall("ram", {{0, 50}, {0, 0}}, motion)
                .grain(0.5, {0.5 + gap, 0.5})
                .stage(solver(1e-2, 20));
            SerialRun run(b.scene());
            try {
                for (int n = 0; n < 50; ++n) {
                    run.steps(1);
                    ASSERT_GT(run.grain(0).x[0], run.simulation().walls().points(1)[0][0])
                        << "speed " << speed << " gap " << gap << " step " << n;
                }
                EXPECT_GE(run.grain(0).v[0], (0.5 * speed > gap ? 1 - 1e-9 : 0) * speed);
            } catch (const NumericalFailure& failure) {
                EXPECT_GT(speed, 30) << failure.what();
                EXPECT_NE(std::string(failure.what()).find("grain 0 "), std::string::npos) << failure.what();
            }
        }
    }
}

/// Pressed into the joint of two segments by the weight of a heavy disk, a light one neither slips between them nor goes through.
TEST(Tunnelling, NothingSlipsBetweenTwoSegments) {
    for (const double bend : {-0.8, -0.1, 0.0, 0.1, 0.8}) { // ridge … valley
        SceneBuilder b(0.2);
        b.wall("floor", {{-20, 20 * bend}, {0, 0}, {20, 20 * bend}});
        b.wall("left", {{-2, 40}, {-2, -20}}).wall("right", {{2, -20}, {2, 40}});
        b.grain(0.2, {0, bend > 0 ? 0.2 / std::cos(std::atan(bend)) : 0.2}).grain(1.5, {0.01, 2.5});
        b.stage(solver(2e-3, 50));
        SerialRun run(b.scene());
        for (int n = 0; n < 2000; ++n) {
            run.steps(1);
            const auto x = run.grain(0).x;
            // Its centre stays above the floor under it; half a radius of overlap would count as lost.
            ASSERT_GT(x[1] - std::abs(x[0]) * bend, 0.1) << "bend " << bend << " step " << n;
        }
    }
}

/// A piston that moves at V from t_1 to t_2 pushes a disk on a smooth floor: at rest before, at V while it is pushed, and on at V
/// when the piston has stopped (an inelastic wall pushes, it does not hold). The piston itself goes V (t_2 - t_1).
TEST(MovingWall, PistonPushesAtItsSpeed) {
    const double r = 0.5, h = 1e-2, v = 0.3;
    Motion<2> motion;
    motion.velocity = {v, 0};
    motion.start = 0.5;
    motion.stop = 1.5;
    for (const double theta : {0.5, 1.0}) {
        SceneBuilder b(0);
        b.floor().moving_wall("piston", {{0, 2}, {0, 0}}, motion).grain(r, {r, r}).stage(solver(h, 30, theta));
        SerialRun run(b.scene());
        for (int n = 1; n <= 250; ++n) {
            run.steps(1);
            const bool before = n <= 50, during = n > 50 && n <= 150;
            ASSERT_NEAR(run.grain(0).v[0], before ? 0 : v, 1e-12) << "step " << n;
            ASSERT_NEAR(run.normal_impulse(0, wall_id(1)), n == 51 ? disk_mass(r) * v : 0, 1e-9) << "step " << n;
            if (during) { // in touch
                EXPECT_NEAR(run.grain(0).x[0] - run.simulation().walls().points(1)[0][0], r, 1e-12) << "step " << n;
            }
        }
        // theta = 1 counts the whole of the first step and nothing of the step after the last.
        EXPECT_NEAR(run.simulation().walls().points(1)[0][0], v * 1.0, 1e-12);
        EXPECT_NEAR(run.grain(0).x[0], r + v * (2.0 - (theta == 1.0 ? 0.0 : 0.5 * h)), 1e-12);
    }
}

/// A wall that starts with a stage stays where it is before, and its friction carries a disk along: (1/3) of the plate's speed when
/// rolling has set in, since the plate drives at the rim (v = J/m, s = 2 J/m, v + s = V).
TEST(MovingWall, PlateStartsWithItsStage) {
    const double r = 0.5, h = 1e-2, v = 0.6;
    Motion<2> motion;
    motion.velocity = {v, 0};
    motion.stage = 1;
    SceneBuilder b(0.4);
    b.moving_wall("plate", {{-50, 0}, {50, 0}}, motion).grain(r, {0, r}).stage(solver(h, 5)).stage(solver(h, 5));
    SerialRun run(b.scene());
    run.steps(30);
    EXPECT_EQ(run.grain(0).v[0], 0);
    EXPECT_EQ(run.simulation().walls().points(0)[0][0], -50);
    run.simulation().start_stage(1);
    run.steps(100);
    EXPECT_NEAR(run.grain(0).v[0], v / 3, 1e-12);
    EXPECT_NEAR(run.rim_speed(0), 2 * v / 3, 1e-12);
}

} // namespace
} // namespace nappe::test::walls_test
