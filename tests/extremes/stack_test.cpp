// Stacks of 10 to 1,000 disks, radius ratios to 1,000.

#include "extremes/heavy_scenes.hpp"

#include <gtest/gtest.h>

namespace nappe::test::stack_test {
namespace {

constexpr double h = 5e-3;

/// NSGS carries a force over n contacts in n² sweeps or so: the slowest mode of the stack keeps cos²(pi/(2n+1)) of itself
/// in a sweep of both colours, so a decade takes ln(10) (2n+1)²/pi² sweeps.
TEST(Stacks, SolvedCold) {
    const double tolerance = 1e-6;
    for (const double n : decades(10, long_form() ? 1000 : 100, std::sqrt(10.0))) {
        const int disks = static_cast<int>(std::lround(n));
        auto settings = solver(h, 10);
        settings.tolerance = tolerance;
        settings.max_sweeps = 1'000'000'000;
        const auto scene = column("stack", 1, disks, true);
        const auto step = solve_cold(scene, settings);
        const double decade = std::log(10.0) * std::pow((2 * disks + 1) / std::numbers::pi, 2);
        found("stacks", disks, step.sweeps, digits(step.sweeps / decade), digits(step.residual),
              digits(step.force_error));
        EXPECT_LE(step.residual, tolerance);
        EXPECT_LE(step.force_error, disks * step.residual + 1e-9);
        EXPECT_LE(step.sweeps, 7 * decade + 20) << "six decades, and the modes but the slowest";
    }
}

/// 100 sweeps a step, started cold: a stack too high for them sinks into itself until forces are there.
TEST(Stacks, InTime) {
    for (const double n : decades(10, long_form() ? 1000 : 100, std::sqrt(10.0))) {
        auto scene = column("stack", 1, static_cast<int>(std::lround(n)), true);
        Stage stage;
        stage.name = "rest";
        stage.duration = 1;
        stage.solver = solver(h, 100);
        scene.scene.stages = {stage};
        SerialRun run(scene.scene);
        const double energy = potential(run);
        const auto said = run_or_refusal(run, 200);
        found("stacks in time", std::lround(n), digits(overlaps(run.simulation()).largest),
              said.empty() ? digits(force_error(run, scene, h)) : "refused");
        EXPECT_TRUE(all_finite(run));
        EXPECT_LE(overlaps(run.simulation()).largest, 1);
        EXPECT_LE(kinetic(run) + potential(run), energy * (1 + 1e-12));
    }
}

/// A large disk on two small ones between walls, at equal masses and at equal densities. Both contacts are nearly level
/// then, and forces badly conditioned: the factor between residual and force error grows as the ratio squared.
TEST(Radii, LargeOnSmall) {
    for (const double size : decades(1, 1000, long_form() ? 2 : 10)) {
        for (const bool equal_masses : {true, false}) {
            const double ratio = equal_masses ? 1 : size * size;
            if ((ratio > 1e4 && !long_form()) || (size == 1 && !equal_masses)) {
                continue; // Gauss-Seidel takes 20 sweeps times the ratio; at size 1 both are one
            }
            const auto scene = cushion("large on two", ratio, 2, size);
            const auto step = solve_cold(scene, solver(h, static_cast<int>(100 + 50 * size + 20 * ratio)));
            found("radii", digits(size), digits(ratio), step.sweeps, digits(step.residual), digits(step.force_error));
            // A sweep that would change less than round-off changes nothing: that hides eps x ratio of a residual.
            const double hidden = 1e-9 + 2.2e-16 * ratio * scene.factor;
            EXPECT_LE(step.force_error, scene.factor * step.residual + hidden) << size;
            EXPECT_LE(step.residual, 1e-4) << size;
        }
    }
}

/// Small disks rain on a large one and lie on it or run off: nothing enters it, nothing goes through the floor, no
/// energy comes from anywhere.
TEST(Radii, SmallOnLarge) {
    for (const double size : decades(1, 1000)) {
        const double r = 1 / size;
        SceneBuilder b(0.3);
        b.floor(20).grain(1, {0, 1});
        for (int k = 0; k < 5; ++k) {
            b.grain(r, {0.1 * r * (k - 1), 2.1 + r * (1 + 2.2 * k)});
        }
        b.stage(solver(2e-3, 50));
        SerialRun run(b.scene());
        const double at_start = potential(run);
        double most = 0, overlap = 0;
        const auto said = run_or_refusal(run, long_form() ? 5000 : 1000, [&] {
            most = std::max(most, (kinetic(run) + potential(run)) / at_start);
            overlap = std::max(overlap, overlaps(run.simulation()).largest);
        });
        found("small on large", digits(size), digits(overlap), digits(most), said);
        EXPECT_EQ(said, "") << size;
        EXPECT_TRUE(all_finite(run));
        EXPECT_LE(most, 1 + 1e-12) << size;
        EXPECT_LE(overlap, 0.5) << size;
    }
}

} // namespace
} // namespace nappe::test::stack_test
