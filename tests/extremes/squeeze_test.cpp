// Walls that close on grains, where no impulse solves a step; exact degeneracies; rest.

#include "extremes/findings.hpp"

#include <gtest/gtest.h>

namespace nappe::test {
namespace {

/// Two walls close on a stack of disks until nothing fits. Overlaps grow, which is in every row of the series; before a
/// centre leaves the walls the run ends and says where.
TEST(ClosingWalls, AreADiagnosis) {
    for (const double speed : {0.01, 1.0, 30.0, 100.0, 1e4}) {
        for (const int n : {1, 4}) {
            for (const int sweeps : {1, 100}) {
                for (const bool tolerance : {false, true}) {
                    SceneBuilder b(0.3);
                    Motion<2> right, left;
                    right.velocity = {speed, 0};
                    left.velocity = {-speed, 0};
                    b.floor(10).moving_wall("left", {{-1.5, 9}, {-1.5, -1}}, right);
                    b.moving_wall("right", {{1.5, -1}, {1.5, 9}}, left);
                    for (int k = 0; k < n; ++k) {
                        b.grain(0.5, {0.01 * k, 0.5 + 1.01 * k});
                    }
                    auto settings = solver(5e-3, sweeps);
                    if (tolerance) {
                        settings.tolerance = 1e-4;
                        settings.max_sweeps = 200;
                    }
                    b.stage(settings);
                    SerialRun run(b.scene());
                    const auto most = static_cast<std::int64_t>(2 * 1.5 / (speed * 5e-3)) + 100;
                    std::int64_t steps = 0;
                    const auto said = run_or_refusal(run, most, [&] { ++steps; });
                    const bool passed = said.find("came into the other") != std::string::npos;
                    if (!tolerance) {
                        found("closing walls", digits(speed), n, sweeps, steps,
                              said.empty() ? "nothing" : (passed ? "through a grain" : "through a wall"));
                    }
                    EXPECT_NE(said.find("grain"), std::string::npos) << speed << ": nothing was said in " << steps;
                    EXPECT_TRUE(said.find("went through") != std::string::npos ||
                                said.find("farther than tiles allow") != std::string::npos)
                        << said;
                }
            }
        }
    }
}

/// One hits two that touch: all in a line, exactly. Inelastic, the three go on together; e = 1 by Newton's law, where all
/// contacts act at once, the last two part from the first as one (no Newton's cradle: that takes one impact after the other).
TEST(Degenerate, ThreeInALine) {
    for (const double e : {0.0, 1.0}) {
        for (const double phase : {0.0, 0.25, 0.5}) {
            SceneBuilder b(0.4, e);
            b.gravity(0, 0)
                .grain(0.5, {0, 0}, {1, 0})
                .grain(0.5, {1.25 + phase / 64, 0})
                .grain(0.5, {2.25 + phase / 64, 0});
            b.stage(solver(1.0 / 64, 200));
            SerialRun run(b.scene());
            run.steps(64);
            EXPECT_NEAR(momentum(run)[0], disk_mass(0.5), 1e-9 * disk_mass(0.5));
            for (int k = 0; k < 3; ++k) {
                EXPECT_EQ(run.grain(k).x[1], 0) << "nothing pushes sideways";
                EXPECT_EQ(run.grain(k).spin[0], 0);
            }
            EXPECT_LE(kinetic(run), 0.5 * disk_mass(0.5) * (1 + 1e-12)) << "e " << e;
            found("line", e, phase, digits(run.grain(0).v[0]), digits(run.grain(1).v[0]), digits(run.grain(2).v[0]));
            if (e == 0) {
                for (int k = 0; k < 3; ++k) {
                    EXPECT_NEAR(run.grain(k).v[0], 1.0 / 3, 1e-9);
                }
            }
        }
    }
}

/// Equal disks in a triangular crystal between walls, all contacts touching to round-off: the floor carries the weight,
/// the walls balance, nothing moves.
TEST(Degenerate, CrystalBetweenWalls) {
    for (const double mu : {0.0, 0.4}) {
        const double r = 0.5, h = 5e-3, rise = std::sqrt(3.0) * r;
        const int n = 6, layers = 6;
        SceneBuilder b(mu);
        b.wall("floor", {{0, 0}, {2 * r * n, 0}});
        b.wall("left", {{0, 10}, {0, 0}}).wall("right", {{2 * r * n, 0}, {2 * r * n, 10}});
        int count = 0;
        for (int layer = 0; layer < layers; ++layer) {
            for (int k = 0; k < n - layer % 2; ++k, ++count) {
                b.grain(r, {r * (2 * k + 1 + layer % 2), r + layer * rise});
            }
        }
        b.stage(solver(h, 2000)).stage(solver(h, 50));
        SerialRun run(b.scene());
        run.steps(20);
        run.simulation().start_stage(1);
        const auto before = run.simulation().grain_rows();
        run.steps(long_form() ? 100'000 : 1000);
        Vec<2> force = Vec<2>::Zero();
        for (const auto& c : run.loaded_contacts()) {
            if (c.wall >= 0) {
                force += (c.r_n * Vec<2>(c.normal[0], c.normal[1]) + c.r_t[0] * Vec<2>(-c.normal[1], c.normal[0])) / h;
            }
        }
        const double weight = count * disk_mass(r) * standard_gravity;
        double moved = 0;
        for (const auto& row : before) {
            const auto now = run.grain(row.id);
            moved = std::max(moved, std::hypot(now.x[0] - row.x[0], now.x[1] - row.x[1]) / r);
        }
        found("crystal", mu, digits(force[0] / weight), digits(force[1] / weight - 1), digits(moved));
        EXPECT_NEAR(force[0] / weight, 0, 1e-9) << mu;
        EXPECT_NEAR(force[1] / weight, 1, 1e-9) << mu;
        EXPECT_LE(moved, 1e-9) << mu;
    }
}

/// A disk on the very corner of two tiles' edges, one on the joint of two segments, one on the end of a wall, one right
/// between two others, one whose way ends where it touches: ties in every comparison that there is.
TEST(Degenerate, Ties) {
    const double r = 0.5;
    SceneBuilder b(0.4);
    b.scene().tiles.side = 8;
    b.wall("floor", {{-16, 0}, {-8, 0}, {0, 0}, {8, 0}, {16, 0}}).wall("shelf", {{20, 0}, {22, 0}});
    b.grain(r, {0, r}).grain(r, {8, r}).grain(r, {7, r}).grain(r, {9, r});
    b.grain(r, {8, 2 * r + r}); // on the joint's own grain, right above it
    b.grain(r, {22, r});        // on the end of the shelf
    b.grain(r, {-8, 8});        // on a corner of four tiles
    b.stage(solver(1.0 / 128, 200));
    SerialRun run(b.scene());
    const double start = potential(run);
    run.steps(512);
    EXPECT_TRUE(all_finite(run));
    EXPECT_LE(kinetic(run) + potential(run), start);
    EXPECT_EQ(run.grain(4).x[0], 8) << "a tie that is broken pushes it to one side";
    EXPECT_NEAR(run.grain(4).x[1], 3 * r, 1e-9);
    EXPECT_EQ(run.grain(5).x[0], 22) << "balanced on a point";
    EXPECT_EQ(run.grain(6).x[0], -8);
    EXPECT_NEAR(run.grain(6).x[1], r, 1e-9);
}

/// A pile of ten, 4 + 3 + 2 + 1 on a floor, held by friction: as many steps as one has patience for, and nothing creeps.
TEST(Rest, PileDoesNotDrift) {
    const double r = 0.37, h = 5e-3;
    SceneBuilder b(1); // with 0.6 a triangle of ten rolls apart
    b.floor(10);
    for (int layer = 0; layer < 4; ++layer) {
        for (int k = 0; k < 4 - layer; ++k) {
            b.grain(r, {r * (2 * k + layer), r + layer * std::sqrt(3.0) * r});
        }
    }
    b.stage(solver(h, 5000)).stage(solver(h, 10));
    SerialRun run(b.scene());
    run.steps(20);
    run.simulation().start_stage(1);
    const auto before = run.simulation().grain_rows();
    const std::int64_t steps = long_form() ? 1'000'000 : 20'000;
    run.steps(steps);
    double moved = 0, turned = 0;
    for (const auto& row : before) {
        const auto now = run.grain(row.id);
        moved = std::max(moved, std::hypot(now.x[0] - row.x[0], now.x[1] - row.x[1]) / r);
        turned = std::max(turned, std::abs(now.rotation[0] - row.rotation[0]));
    }
    found("rest", steps, digits(moved), digits(turned), digits(kinetic(run)));
    // A residual of round-off, 1e-12 of V = g h, is 1e-15 r a step, if it all goes one way.
    EXPECT_LE(moved, 1e-12 * standard_gravity * h * h / r * static_cast<double>(steps));
    EXPECT_LE(turned, 1e-12 * standard_gravity * h * h / r * static_cast<double>(steps));
}

} // namespace
} // namespace nappe::test
