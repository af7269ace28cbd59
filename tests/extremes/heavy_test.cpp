// Mass ratios from 1 to 1e6, heavy on light and light on heavy: what sweeps buy, in residual and in force.
//
// What a residual bounds. In a stack every active contact has u_a = n·(v_a - v_b) + b with |u_a| <= res V, so the j-th
// disk from below moves with |v_j| <= j res V where it should rest. What contact k transmits differs from the weight
// above it by the momentum that the disks above it gain: h |f_k - f_k*| <= sum m_j |v_j| <= n res V sum m_j, and with
// V = h g and the weight W of all: |f - f*| / W <= n res, n the disks on top of each other. No smaller factor holds for
// all stacks. On a row the heavy disk stands on two contacts at an angle phi to the vertical, the small ones under it
// move by res V upwards and by n/2 res V sideways at most, so it may move by (1 + cos phi + n/2 sin phi) res V over cos phi
// upwards and over sin phi sideways; two forces N that let it do so differ by its momentum along, over 2 cos phi, and
// across, over 2 sin phi. On many contacts with friction (three layers) nothing is derived: the stack's factor is asked.

#include "extremes/heavy_scenes.hpp"
#include "io/scene_reader.hpp"

#include <gtest/gtest.h>

namespace nappe::test {
namespace {

constexpr double h = 5e-3;
constexpr double round_off = 1e-9; // of forces: 1e-16 m in gaps, over h and V, times sweeps that add it up

TEST(Heavy, ForcesAgainstStatics) {
    for (const double ratio : decades(1, 1e6, long_form() ? 10 : 1000)) {
        for (const auto& scene : heavy_scenes(ratio)) {
            double before = 2;
            for (const double sweeps : decades(100, long_form() ? 1e6 : 1e5)) {
                const auto step = solve_cold(scene, solver(h, static_cast<int>(sweeps)));
                found("heavy", scene.name, digits(ratio), step.sweeps, digits(step.residual), digits(step.force_error),
                      step.residual > round_off ? digits(step.force_error / step.residual) : "");
                ASSERT_TRUE(std::isfinite(step.residual) && std::isfinite(step.force_error)) << scene.name;
                EXPECT_LE(step.force_error, scene.factor * step.residual + round_off) << scene.name << " " << ratio;
                EXPECT_LE(step.force_error, before * 1.01 + round_off) << scene.name << ": more sweeps, worse forces";
                before = step.force_error;
            }
        }
    }
}

struct NamedMethod {
    const char* name;
    SolverSettings::Method method;
};

/// Every solver is asked the same: how many sweeps to a residual of 1e-8, and what the forces are worth then. What bounds
/// the force error knows nothing of how a residual was reached.
TEST(Heavy, EverySolver) {
    using Method = SolverSettings::Method;
    for (const auto& [name, method] : {NamedMethod{"nsgs", Method::nsgs},
                                       {"ansgs", Method::ansgs},
                                       {"nncg", Method::nncg},
                                       {"apgd", Method::apgd},
                                       {"cpg", Method::cpg}}) {
        for (const double ratio : decades(1, 1e6, long_form() ? 10 : 1000)) {
            for (const auto& scene : heavy_scenes(ratio)) {
                auto settings = solver(h, 10);
                settings.method = method;
                settings.tolerance = 1e-8;
                settings.max_sweeps = long_form() ? 100'000 : 10'000;
                const auto step = solve_cold(scene, settings);
                found("solvers", name, scene.name, digits(ratio), step.sweeps, digits(step.residual),
                      digits(step.force_error), step.converged ? "converged" : "");
                ASSERT_TRUE(std::isfinite(step.residual) && std::isfinite(step.force_error)) << name << scene.name;
                EXPECT_TRUE(step.converged || step.sweeps >= settings.max_sweeps) << name << ", " << scene.name;
                // A check acts at once, or four sweeps later where the residual falls steadily (nsgs).
                EXPECT_LE(step.converged ? step.residual : 0.0, *settings.tolerance) << name << ", " << scene.name;
                EXPECT_LE(step.force_error, scene.factor * step.residual + round_off)
                    << name << ", " << scene.name << ", " << ratio;
            }
        }
    }
}

/// Two contacts, floor and heavy: a sweep leaves the share 1/((1/m)^-1 (1/m + 1/M)) = 1/(1 + m/M) of the error in the
/// force between the two, whichever comes first. So a ratio q takes q ln(10) sweeps a decade, cold.
TEST(Heavy, SweepsOfGaussSeidelGrowWithTheRatio) {
    for (const double ratio : decades(1, 1e6)) {
        const int sweeps = static_cast<int>(std::ceil(ratio));
        const auto step = solve_cold(column("heavy on one", ratio, 2, true), solver(h, sweeps));
        // The floor's own first impulse is the light disk's weight, one part in 1 + q; the count may be one sweep off.
        const double share = std::pow(1 + 1 / ratio, -sweeps);
        EXPECT_NEAR(step.force_error, share, 2 / (1 + ratio)) << ratio;
    }
}

/// The sweeps of ordinary effort, step after step with warm start: the light one is pressed flat before the force is
/// there, or the user hears of it.
TEST(Heavy, InTime) {
    for (const double ratio : decades(1, 1e6)) {
        for (auto& scene : heavy_scenes(ratio)) {
            Stage stage;
            stage.name = "rest";
            stage.duration = 1;
            stage.solver = solver(h, 100);
            scene.scene.stages = {stage};
            SerialRun run(scene.scene);
            const double energy = potential(run);
            const auto heavy = static_cast<GlobalId>(scene.scene.grains.size()) - 1;
            const double start = run.grain(heavy).x[1];
            double overlap = 0;
            const auto said =
                run_or_refusal(run, 200, [&] { overlap = std::max(overlap, overlaps(run.simulation()).largest); });
            found("heavy in time", scene.name, digits(ratio), digits(overlap),
                  digits((start - run.grain(heavy).x[1]) / light_radius),
                  said.empty() ? digits(force_error(run, scene, h)) : "refused");
            EXPECT_TRUE(said.empty() || said.find("went through") != std::string::npos) << said;
            EXPECT_TRUE(all_finite(run)) << scene.name;
            EXPECT_TRUE(overlap <= 1 || !said.empty())
                << scene.name << " " << ratio << ": a centre inside another grain, and nobody said so";
            // At rest at the start: all energy comes from sinking.
            EXPECT_LE(kinetic(run) + potential(run), energy + 1e-9 * std::abs(energy)) << scene.name << " " << ratio;
        }
    }
}

/// Contacts without friction are a quadratic problem: conjugate gradients solve it in about as many steps as it has
/// contacts (23 here), whatever the masses. A step passes three times over the contacts: 300 sweeps' work is 100 of them.
TEST(Heavy, ConjugateGradientsDoNotPayForTheRatio) {
    for (const double ratio : decades(1, 1e6)) {
        for (const auto& scene : heavy_scenes(ratio)) {
            if (scene.name == std::string("heavy on three layers")) {
                continue; // friction
            }
            auto settings = solver(h, 10);
            settings.method = SolverSettings::Method::cpg;
            settings.tolerance = 1e-8;
            settings.max_sweeps = 100;
            const auto step = solve_cold(scene, settings);
            EXPECT_TRUE(step.converged) << scene.name << " " << ratio << ": " << step.residual;
            EXPECT_LE(step.force_error, scene.factor * *settings.tolerance + round_off) << scene.name << " " << ratio;
        }
    }
}

/// The settings that `accuracy = "tight"` chooses.
SolverSettings tight() {
    const auto scene = parse_scene(R"(
accuracy = "tight"
[world]
dimension = 2
gravity = [0, -9.81]
[materials.rock]
density = 2800
[[laws]]
between = ["rock", "rock"]
type = "frictional"
friction = 0.4
[[laws]]
between = ["rock", "wall"]
type = "frictional"
friction = 0.4
[[grains]]
material = "rock"
radius = 1
position = [0, 1]
[[walls]]
name = "floor"
points = [[-1, 0], [1, 0]]
[[stages]]
name = "rest"
duration = 1
[solver]
h = 0.005
)",
                                   "tight.toml");
    return scene.stages[0].solver;
}

/// What a user is promised of forces: 1 % of the weight, from the first, cold step on.
TEST(Heavy, TightForces) {
    for (const double ratio : decades(1, 1e6)) {
        for (auto& scene : heavy_scenes(ratio)) {
            Stage stage;
            stage.name = "rest";
            stage.duration = 1;
            stage.solver = tight();
            scene.scene.stages = {stage};
            SerialRun run(scene.scene);
            double first = 0, worst = 0, residual = 0;
            for (int k = 0; k < 200; ++k) {
                run.steps(1, true);
                const double error = force_error(run, scene, stage.solver.h / stage.solver.substeps);
                const double left = run.simulation().last_residual()->largest;
                first = k == 0 ? error : first;
                worst = std::max(worst, error);
                residual = std::max(residual, left);
            }
            found("heavy tight", scene.name, digits(ratio), run.simulation().counters().sweeps / 200, digits(residual),
                  digits(first), digits(worst), residual > round_off ? digits(worst / residual) : "",
                  digits(overlaps(run.simulation()).largest));
            EXPECT_LE(worst, 0.01) << scene.name << " " << ratio;
        }
    }
}

} // namespace
} // namespace nappe::test
