// Steps of 1e-7 to 1 s, gravity of 0, 1e-6 and 1e6 m/s², densities of 1e-3 to 1e6 kg/m³.

#include "extremes/heavy_scenes.hpp"

#include <gtest/gtest.h>

namespace nappe::test {
namespace {

Scene<2> with_stage(Scene<2> scene, const SolverSettings& settings) {
    Stage stage;
    stage.name = "only";
    stage.duration = 1;
    stage.solver = settings;
    scene.stages = {stage};
    return scene;
}

/// Five disks at rest on each other. A gap is a difference of positions of some metres, 1e-16 of them wrong; over h it is a
/// velocity, to be compared with h g: forces are good to 5 eps / (g h²) of themselves and not better.
TEST(Scales, StepAtRest) {
    for (const double h : decades(1e-7, 1, long_form() ? std::sqrt(10.0) : 10)) {
        const auto column = test::column("five", 1, 5, true);
        SerialRun run(with_stage(column.scene, solver(h, 500)));
        const auto said = run_or_refusal(run, 200);
        const double error = force_error(run, column, h);
        found("steps", digits(h), digits(overlaps(run.simulation()).largest), digits(error), said);
        EXPECT_EQ(said, "") << h;
        EXPECT_TRUE(all_finite(run)) << h;
        const double eps = 1.1e-16 * 5;
        EXPECT_LE(error, 1e-9 + 10 * eps / (standard_gravity * h * h)) << h;
    }
}

/// A disk falls 5 m on a floor: it lies there in the end, or a step is refused as too long for the tiles.
TEST(Scales, StepOfAFall) {
    for (const double h : decades(1e-4, 1, long_form() ? std::sqrt(10.0) : 10)) {
        SceneBuilder b(0.4);
        b.floor(10).grain(0.5, {0, 5.5}).stage(solver(h, 100));
        SerialRun run(b.scene());
        const auto said = run_or_refusal(run, static_cast<std::int64_t>(std::ceil(3 / h)));
        const double overlap = (0.5 - run.grain(0).x[1]) / 0.5;
        found("fall", digits(h), said.empty() ? digits(overlap) : "refused");
        EXPECT_TRUE(said.empty() || said.find("farther than tiles allow") != std::string::npos) << said;
        if (said.empty()) {
            // It comes down with 10 m/s, 10 m/s x h a step, and is stopped where a linear gap closes: a flat floor's is.
            EXPECT_NEAR(overlap, 0, 1e-9) << h;
            EXPECT_NEAR(run.grain(0).v[1], 0, 1e-9) << h;
        }
        EXPECT_EQ(said.empty(), h < 0.2) << "3 r_max is what default tiles allow: 1.5 m at 10 m/s";
    }
}

/// The same column under any gravity; h such that h² g, what a step falls, is the same.
TEST(Scales, Gravity) {
    for (const double gravity : {1e-6, 1e-3, 1.0, 1e3, 1e6}) {
        const double h = 5e-3 * std::sqrt(standard_gravity / gravity);
        auto column = test::column("five", 1, 5, true);
        column.scene.gravity = {0, -gravity};
        for (auto& force : column.known) {
            force.newtons *= gravity / standard_gravity;
        }
        column.weight *= gravity / standard_gravity;
        SerialRun run(with_stage(column.scene, solver(h, 500)));
        const auto said = run_or_refusal(run, 200);
        found("gravity", digits(gravity), digits(h), digits(overlaps(run.simulation()).largest),
              digits(force_error(run, column, h)), said);
        EXPECT_EQ(said, "") << gravity;
        EXPECT_LE(force_error(run, column, h), 1e-9) << gravity;
        EXPECT_LE(overlaps(run.simulation()).largest, 1e-9) << gravity;
    }
}

/// Nothing moves where nothing pulls, and nothing is divided by the velocity scale, which is 0 then.
TEST(Scales, NoGravity) {
    auto column = test::column("five", 1, 5, true);
    column.scene.gravity = {0, 0};
    SerialRun run(with_stage(column.scene, solver(5e-3, 50)));
    run.steps(1000, true);
    EXPECT_EQ(kinetic(run), 0);
    EXPECT_EQ(run.simulation().last_residual()->largest, 0);
    for (int k = 0; k < 5; ++k) {
        EXPECT_EQ(run.grain(k).x[1], light_radius * (2 * k + 1));
    }
    found("gravity", "0", "0.005", "0", "", "");
}

/// Gravity that a step can not carry: refused, not wrapped around.
TEST(Scales, GravityTooStrongForTheStep) {
    for (const double gravity : {1e3, 1e6, 1e12}) {
        SceneBuilder b(0.4);
        b.gravity(0, -gravity).floor(10).grain(0.5, {0, 5.5}).stage(solver(0.1, 100));
        SerialRun run(b.scene());
        const auto said = run_or_refusal(run, 100);
        EXPECT_NE(said.find("farther than tiles allow"), std::string::npos) << gravity << ": " << said;
    }
}

/// Densities are a scale: by a power of two every impulse is, to the bit, and no position or velocity changes.
TEST(Scales, Density) {
    const auto run_with = [](double density) {
        SceneBuilder b(0.4, 0);
        b.scene().materials[0].density = density;
        b.box(6, 5, {RadiusLaw::Kind::uniform, 0.3, 0.5}, 7).stage(solver(5e-3, 30));
        SerialRun run(b.scene());
        run.steps(200);
        auto rows = run.simulation().grain_rows();
        std::sort(rows.begin(), rows.end(), [](const auto& p, const auto& q) { return p.id < q.id; });
        return rows;
    };
    const auto reference = run_with(1024);
    for (const double density : {0x1p-10, 0x1p-4, 0x1p20}) { // 1e-3, 0.06, 1e6 kg/m³
        const auto rows = run_with(density);
        ASSERT_EQ(rows.size(), reference.size());
        for (std::size_t k = 0; k < rows.size(); ++k) {
            EXPECT_EQ(rows[k].x, reference[k].x) << density;
            EXPECT_EQ(rows[k].v, reference[k].v) << density;
            EXPECT_EQ(rows[k].spin, reference[k].spin) << density;
            EXPECT_EQ(rows[k].mass * (1024 / density), reference[k].mass) << density;
        }
    }
    for (const double density : decades(1e-3, 1e6)) {
        auto column = test::column("five", 1, 5, true);
        for (auto& material : column.scene.materials) {
            material.density = density;
        }
        for (auto& force : column.known) {
            force.newtons *= density / light_density;
        }
        column.weight *= density / light_density;
        const auto step = solve_cold(column, solver(5e-3, 500));
        found("density", digits(density), digits(step.residual), digits(step.force_error));
        EXPECT_LE(step.force_error, 1e-9) << density;
    }
}

} // namespace
} // namespace nappe::test
