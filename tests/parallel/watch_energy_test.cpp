// The watch over a whole state, not over grains: energy that comes from nowhere, a residual that stays; on all ranks alike.
#include "support/watched_run.hpp"

#include <gtest/gtest.h>

#include <numbers>
#include <utility>

namespace nappe {
namespace {

using test::SceneBuilder;
using test::squeezed;
using test::WatchedRun;
using Then = WatchSettings<2>::Then;

class WatchEnergy : public test::WatchTest {};

TEST_F(WatchEnergy, EnergyFromWrongImpulsesIsMeasuredAndNamed) {
    // Impulses that the grains never had, as a damaged store might hold them, and one sweep that can not take them back.
    // Of three in a row, the contact of the first two comes first, so that some of what the other gave to the middle one
    // has gone on to the first when that is taken back: 3/16 r²/m stay (by the impacts, one after the other).
    SceneBuilder b;
    b.floor(100);
    std::vector<ContactRow<2>> impulses;
    for (int k = 0; k < 12; ++k) {
        for (int j = 0; j < 3; ++j) {
            b.grain(0.5, {7.0 * k - 42 + j, 0.5});
        }
        impulses.push_back({3 * k + 1, 3 * k + 2, k == 9 ? 4e4 : 1e3, {0}});
    }
    b.stage(test::solver(0.01, 1));
    auto scene = b.scene();
    scene.watch.energy = {0.1, Then::warn};
    const auto grains = initial_grains(scene);
    WatchedRun run(world, scene, grains, impulses);
    const Energies before = energies(run.simulation());
    EXPECT_EQ(run.steps(1), "");
    const Energies after = energies(run.simulation());
    const auto& s = run.simulation();
    const double scale = before.kinetic + s.total_mass() * test::standard_gravity * s.mean_radius();
    const double growth = (after.kinetic + after.potential - before.kinetic - before.potential) / scale;
    ASSERT_GT(growth, 0.1) << "no energy came: too easy";
    EXPECT_NEAR(run.memory().largest_growth, growth, 1e-12 * growth);
    EXPECT_EQ(run.found(Watched::energy), 1);
    ASSERT_EQ(run.lines.size(), 1u);
    EXPECT_SAYS(run.lines[0], "energy grew without work in step 1 of stage 'stage 0' (t = 0 s), by ");
    EXPECT_SAYS(run.lines[0], "most of it between grain");
    EXPECT_SAYS(run.lines[0], " 28 ");
    EXPECT_SAYS(run.lines[0], "at [2");
    const double m = 2800 * std::numbers::pi * 0.25, given = 3.0 / 16 * (4e4 * 4e4 + 11 * 1e3 * 1e3) / m;
    EXPECT_NEAR(growth * scale, given, 1e-3 * given) << "but for h m g, which the floor takes within the sweep";

    scene.watch.energy = {growth * (1 + 1e-9), Then::stop};
    WatchedRun under(world, scene, grains, impulses);
    EXPECT_EQ(under.steps(5), "");
    scene.watch.energy.limit = growth * (1 - 1e-9);
    WatchedRun over(world, scene, grains, impulses);
    const auto said = over.steps(5);
    EXPECT_SAYS(said, "energy grew without work in step 1 of");
    WatchedRun one(alone, scene, grains, impulses);
    EXPECT_EQ(one.steps(5), said);
}

TEST_F(WatchEnergy, WorkOfWallsAndOfBondsIsNoGrowth) {
    // A wall that starts at once brings all the energy that there is.
    auto scene = squeezed(1, 1);
    scene.stages[0].solver.sweeps = 200;
    scene.watch.energy.limit = 1e-9;
    WatchedRun pushed(world, scene);
    EXPECT_EQ(pushed.steps(30), "");
    EXPECT_GT(energies(pushed.simulation()).kinetic, 0);
    EXPECT_EQ(pushed.found(Watched::energy), 0) << pushed.memory().largest_growth;
    // Bonded pairs that attract each other over their gap, from rest: all of it is the work of bonds.
    for (const auto& [substeps, every] : {std::pair{1, 1}, {4, 1}, {4, 4}}) {
        SceneBuilder b(0.4);
        b.gravity(0, 0).cohesion(0, 0, 1e4, 0.2);
        for (int k = 0; k < 10; ++k) {
            b.grain(0.5, {5.0 * k, 0}).grain(0.5, {5.0 * k + 1.15, 0});
        }
        auto settings = test::solver(0.002, 10 * substeps);
        settings.substeps = substeps;
        settings.geometry_every = every;
        b.stage(settings);
        b.scene().watch.energy.limit = 1e-9;
        WatchedRun bonded(world, b.scene());
        EXPECT_EQ(bonded.steps(10), "");
        EXPECT_GT(energies(bonded.simulation()).kinetic, 0) << "nothing attracts: too easy";
        EXPECT_EQ(bonded.found(Watched::energy), 0) << bonded.memory().largest_growth << ", substeps " << substeps;
    }
}

TEST_F(WatchEnergy, ResidualAboveTheToleranceStepAfterStep) {
    // Five sweeps do not settle columns of eight.
    SceneBuilder b(0.4);
    b.floor(100);
    for (int k = 0; k < 6; ++k) {
        for (int j = 0; j < 8; ++j) {
            b.grain(0.5, {8.0 * k - 20, 0.5 + j});
        }
    }
    auto settings = test::solver(0.01, 5);
    settings.tolerance = 1e-9;
    settings.max_sweeps = 5;
    b.stage(settings);
    auto scene = b.scene();
    scene.watch.residual = {3, Then::warn};
    WatchedRun run(world, scene);
    EXPECT_EQ(run.steps(2), "");
    EXPECT_EQ(run.found(Watched::residual), 0);
    EXPECT_EQ(run.memory().unconverged_in_row, 2);
    EXPECT_EQ(run.steps(1), "");
    EXPECT_EQ(run.found(Watched::residual), 1);
    ASSERT_EQ(run.lines.size(), 1u);
    EXPECT_SAYS(run.lines[0], "above solver.tolerance = 1e-09 in 3 steps in a row, up to step 3 of stage 'stage 0'");
    EXPECT_SAYS(run.lines[0], "grain");
    scene.watch.residual.then = Then::stop;
    WatchedRun stopped(world, scene);
    const auto said = stopped.steps(10);
    EXPECT_SAYS(said, "up to step 3 of");
    EXPECT_EQ(stopped.simulation().stage_steps(), 2);
    WatchedRun one(alone, scene);
    EXPECT_EQ(one.steps(10), said);
    scene.watch.residual.then = Then::substep;
    scene.watch.max_substeps = 8;
    WatchedRun divided(world, scene);
    EXPECT_SAYS(divided.steps(10), "in 8 substeps");
    // A row that is broken starts again from 0.
    scene.watch.residual.then = Then::warn;
    WatchedRun resumed(world, scene);
    EXPECT_EQ(resumed.steps(2), "");
    auto memory = resumed.memory();
    memory.unconverged_in_row = 0;
    resumed.simulation().watcher().set_memory(memory);
    EXPECT_EQ(resumed.steps(2), "");
    EXPECT_EQ(resumed.found(Watched::residual), 0);
    scene.stages[0].solver.max_sweeps = 100000;
    WatchedRun converging(world, scene);
    memory.unconverged_in_row = 2;
    converging.simulation().watcher().set_memory(memory);
    EXPECT_EQ(converging.steps(5), "");
    EXPECT_EQ(converging.memory().unconverged_in_row, 0);
}

} // namespace
} // namespace nappe
