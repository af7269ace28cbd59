// The watch: each condition caused, found in the step it belongs to, named, and handled as the scene says; on all ranks
// alike, and with the words and the bits of one rank.
#include "support/watched_run.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <tuple>
#include <utility>

namespace nappe {
namespace {

using test::SceneBuilder;
using test::squeezed;
using test::WatchedRun;
using Then = WatchSettings<2>::Then;

class Watch : public test::WatchTest {};

/// Grains at rest without gravity that overlap as given: b = 0 leaves overlaps as they are, by formula. Others lie about, so
/// that tiles go to several ranks.
SceneBuilder overlapping(double overlap) {
    SceneBuilder b(0.4);
    b.gravity(0, 0);
    for (int k = 0; k < 12; ++k) {
        b.grain(0.5, {10.0 * k, 0});
    }
    b.grain(0.5, {75, 0}).grain(0.4, {75 + 0.9 - 0.4 * overlap, 0});
    b.stage(test::solver(0.01, 10));
    b.scene().origin = {1000, 0}; // what is told is in the file's coordinates
    return b;
}

TEST_F(Watch, OverlapIsNamedAndCounted) {
    auto scene = overlapping(0.6).scene();
    scene.watch.overlap = {0.61, Then::warn};
    WatchedRun under(world, scene);
    EXPECT_EQ(under.steps(3), "");
    EXPECT_EQ(under.found(Watched::overlap), 0);
    scene.watch.overlap.limit = 0.59;
    WatchedRun warned(world, scene);
    EXPECT_EQ(warned.steps(20), "");
    EXPECT_EQ(warned.found(Watched::overlap), 20);
    ASSERT_EQ(warned.lines.size(), 5u) << "steps 1, 2, 4, 8 and 16";
    EXPECT_SAYS(warned.lines[0],
                "grains 12 and 13 at [1075, 0] overlap by 0.6 of the smaller radius at the end of step 1 "
                "of stage 'stage 0' (t = 0 s), beyond watch.overlap.limit = 0.59");
    EXPECT_SAYS(warned.lines[4], "step 16 of");
    EXPECT_SAYS(warned.lines[4], "(16 such steps so far)");
    scene.watch.overlap.then = Then::stop;
    WatchedRun stopped(world, scene);
    EXPECT_SAYS(stopped.steps(5), "grains 12 and 13 at [1075, 0] overlap by 0.6");
    EXPECT_EQ(stopped.simulation().stage_steps(), 0);
    scene.watch.overlap.then = Then::substep;
    scene.watch.max_substeps = 4;
    WatchedRun divided(world, scene);
    EXPECT_SAYS(divided.steps(5), "(t = 0 s) in 4 substeps, beyond") << "no substep takes an overlap away";
}

TEST_F(Watch, OverlapIsFoundInTheStepThatMakesItAndUndoneToItsStart) {
    std::int64_t rebuilds_within = 0, redone = 0;
    for (const auto& [substeps, every] : {std::pair{1, 1}, {4, 1}, {6, 3}}) {
        for (const double limit : {0.05, 0.4}) {
            SCOPED_TRACE(testing::Message() << substeps << " substeps, normals for " << every << ", limit " << limit);
            auto scene = squeezed(substeps, every);
            scene.watch.overlap = {1e9, Then::warn};
            WatchedRun free(world, scene);
            ASSERT_EQ(free.steps(1), "");
            while (overlaps(free.simulation()).largest <= limit) {
                ASSERT_EQ(free.steps(1), "");
                ASSERT_LT(free.simulation().stage_steps(), 400) << "nothing is squeezed";
            }
            const auto unwatched = scene;
            scene.watch.overlap = {limit, Then::stop};
            WatchedRun watched(world, scene);
            const auto said = watched.steps(400);
            EXPECT_SAYS(said, "overlap by");
            if (substeps == 1) { // of several, an earlier one may pass the limit and the last come back
                EXPECT_EQ(watched.simulation().stage_steps() + 1, free.simulation().stage_steps());
            } else {
                EXPECT_LE(watched.simulation().stage_steps() + 1, free.simulation().stage_steps());
                EXPECT_GE(watched.simulation().stage_steps() + 3, free.simulation().stage_steps());
            }
            const auto n = watched.simulation().stage_steps();
            WatchedRun again(world, unwatched);
            EXPECT_EQ(again.steps(n), "");
            const auto& counted = watched.simulation().counters();
            rebuilds_within += counted.rebuilds - again.simulation().counters().rebuilds > 1 ? 1 : 0;
            redone += counted.redone_lists - again.simulation().counters().redone_lists;
            const auto start = watched.simulation().time();
            EXPECT_TRUE(watched.simulation().undo_step());
            EXPECT_EQ(watched.simulation().time(), start);
            EXPECT_EQ(watched.simulation().state_hash(), again.simulation().state_hash());
            test::expect_same_places(watched.grains(), again.grains());
            // From there it goes on as if nothing had been: where it is, to the same end, and elsewhere to the same bits.
            EXPECT_EQ(watched.steps(1), said);
            EXPECT_TRUE(watched.simulation().undo_step());
            WatchedRun onward(world, unwatched);
            onward.simulation().resume(watched.simulation().snapshot());
            for (auto* run : {&again, &onward}) {
                EXPECT_EQ(run->steps(3), "");
            }
            EXPECT_EQ(onward.simulation().state_hash(), again.simulation().state_hash());
            EXPECT_EQ(onward.simulation().counters().sweeps, again.simulation().counters().sweeps);
            EXPECT_EQ(onward.simulation().counters().rebuilds, again.simulation().counters().rebuilds);
            EXPECT_EQ(onward.simulation().counters().redone_lists, again.simulation().counters().redone_lists);
            WatchedRun one(alone, scene);
            EXPECT_EQ(one.steps(400), said);
        }
    }
    EXPECT_GT(rebuilds_within, 0) << "no step was undone whose rows had changed: too easy";
    EXPECT_GT(redone, 0) << "no step was undone in which a grain had outrun its list: too easy";
}

TEST_F(Watch, ShorterSubstepsHelpOnAnyNumberOfRanks) {
    for (const auto& [substeps, every, correction] : {std::tuple{1, 1, 0.0}, {2, 1, 0.0}, {4, 4, 0.0}, {4, 2, 0.8}}) {
        // There is room for all, but four sweeps do not tell the far end of it in time.
        auto scene = squeezed(substeps, every, 1.03, correction);
        for (auto& wall : scene.walls) {
            wall.motion->stop = 0.2;
        }
        double largest = 0, mass = 0;
        WatchedRun free(world, scene);
        EXPECT_EQ(free.steps(20,
                             [&] {
                                 const double now = overlaps(free.simulation()).largest;
                                 largest = now > largest ? now : largest;
                             }),
                  "");
        const double limit = 0.7 * largest;
        ASSERT_GT(limit, 1e-6) << "too easy";
        largest = 0;
        scene.watch.overlap = {limit, Then::substep};
        WatchedRun run(world, scene);
        const auto said = run.steps(20, [&] {
            const double now = overlaps(run.simulation()).largest;
            largest = now > largest ? now : largest;
        });
        EXPECT_EQ(said, "");
        EXPECT_GT(run.memory().divided_steps, 0) << "too easy";
        EXPECT_LE(run.memory().divided_steps, 20);
        EXPECT_GE(run.memory().most_substeps, 2 * substeps);
        EXPECT_LE(largest, limit);
        EXPECT_EQ(run.found(Watched::overlap), 0);
        WatchedRun one(alone, scene);
        EXPECT_EQ(one.steps(20), "");
        EXPECT_EQ(one.simulation().state_hash(), run.simulation().state_hash());
        EXPECT_EQ(one.memory().divided_steps, run.memory().divided_steps);
        // Nothing was added up twice: what walls got is what grains lost.
        auto& sums = run.simulation().sums();
        EXPECT_EQ(sums.n_steps(), 20 * substeps);
        sums.for_each_sum([&](ExactSum& sum) { world.sum(sum.limbs()); });
        double momentum = 0;
        for (const auto& g : run.grains()) {
            momentum += g.mass * (g.v[0] - (g.id < 29 ? 0 : 10));
            mass += g.mass;
        }
        EXPECT_NEAR(sums.wall_impulse(0)[0] + sums.wall_impulse(1)[0], -momentum, 1e-9 * mass);
    }
}

TEST_F(Watch, ACentreOutsideTheBounds) {
    // x = 0.25 + 2 t, out of 1 after 0.375 s, at the end of step 13 of 1/32 s (all exact in binary).
    SceneBuilder b;
    b.gravity(0, 0);
    for (int k = 0; k < 8; ++k) {
        b.grain(0.5, {-10.0 * k, 0});
    }
    b.grain(0.5, {0.25, 20}, {2, 0});
    b.stage(test::solver(0.03125, 1));
    auto scene = b.scene();
    scene.watch.bounds = {{-100, -1}, {1, 30}, Then::stop};
    WatchedRun run(world, scene);
    const auto said = run.steps(100);
    EXPECT_SAYS(said,
                "the centre of grain 8 at [1.0625, 20] is outside watch.bounds, [-100, -1] to [1, 30], at the end of "
                "step 13 of stage 'stage 0' (t = 0.375 s)");
    EXPECT_EQ(run.simulation().stage_steps(), 12);
    EXPECT_TRUE(run.simulation().undo_step());
    EXPECT_EQ(run.grains()[8].x[0], 1.0);
    scene.watch.bounds->then = Then::warn;
    WatchedRun warned(world, scene);
    EXPECT_EQ(warned.steps(16), "");
    EXPECT_EQ(warned.found(Watched::bounds), 4);
}

TEST_F(Watch, WhatIsTooFastForOneStepIsTakenInShorterOnes) {
    // 10 m a step, where tiles allow 1.5 m: free flight, x = 1000 t.
    SceneBuilder b;
    b.gravity(0, 0);
    for (int k = 0; k < 8; ++k) {
        b.grain(0.5, {-10.0 * k, 0});
    }
    b.grain(0.5, {0, 20}, {1000, 0});
    b.stage(test::solver(0.01, 2));
    auto scene = b.scene();
    WatchedRun refused(world, scene);
    const auto said = refused.steps(1);
    EXPECT_SAYS(said,
                "grain 8 would move more than 1.4992 m in step 1 of stage 'stage 0' (t = 0 s), from [0, 20], farther");
    scene.watch.failure = Then::substep;
    WatchedRun run(world, scene);
    EXPECT_EQ(run.steps(5), "");
    EXPECT_EQ(run.memory().divided_steps, 5);
    EXPECT_EQ(run.memory().most_substeps, 16)
        << "detection looks one and a half substeps ahead: 1.875 m of 8, 0.94 m of 16";
    EXPECT_NEAR(run.grains()[8].x[0], 50, 1e-12 * 50) << "80 roundings";
    WatchedRun one(alone, scene);
    EXPECT_EQ(one.steps(5), "");
    EXPECT_EQ(one.simulation().state_hash(), run.simulation().state_hash());
    scene.watch.max_substeps = 4;
    WatchedRun not_enough(world, scene);
    EXPECT_SAYS(not_enough.steps(1), "(t = 0 s) in 4 substeps, from [0, 20], farther than tiles allow");
}

TEST_F(Watch, ImpulsesAreOfTheScenesOwnStepWhateverItTook) {
    // A grain at rest on the floor: m g h, while another one is too fast for h.
    SceneBuilder b;
    b.floor(100).grain(0.5, {0, 0.5}).grain(0.5, {-20, 20}, {600, 0});
    b.stage(test::solver(0.01, 4));
    b.scene().watch.failure = Then::substep;
    WatchedRun run(world, b.scene());
    EXPECT_EQ(run.steps(4), "");
    EXPECT_EQ(run.memory().divided_steps, 4) << "too easy";
    const double m = 2800 * std::numbers::pi * 0.25, wanted = m * test::standard_gravity * 0.01;
    const auto rows = world.all_gather(run.simulation().contact_rows());
    ASSERT_EQ(rows.size(), 1u);
    EXPECT_NEAR(rows[0].r_n, wanted, 1e-9 * wanted);
}

TEST_F(Watch, NotANumberIsNamedAndCanBeUndone) {
    const auto scene = overlapping(0).scene();
    for (const bool of_spin : {false, true}) {
        auto grains = initial_grains(scene);
        (of_spin ? grains[7].spin[0] : grains[7].v[1]) = std::numeric_limits<double>::quiet_NaN();
        WatchedRun run(world, scene, grains, {});
        const auto said = run.steps(1);
        EXPECT_SAYS(said, "the velocity of grain 7 is not finite in step 1 of stage 'stage 0' (t = 0 s), at [1070, 0]");
        EXPECT_TRUE(run.simulation().undo_step());
        for (const auto& contact : run.simulation().contact_rows()) {
            EXPECT_EQ(contact.r_n, 0);
        }
    }
}

TEST_F(Watch, SamplesDoNotDependOnIt) {
    auto scene = overlapping(0.6).scene();
    scene.stages[0].until = SettleCriterion{};
    scene.watch.overlap = {0.5, Then::substep};
    scene.watch.failure = Then::substep;
    WatchedRun preparing(world, scene);
    EXPECT_EQ(preparing.steps(3), "");
    EXPECT_EQ(preparing.memory().divided_steps, 0);
    EXPECT_EQ(preparing.found(Watched::overlap), 3) << "it warns";
    scene.watch.overlap.then = Then::stop;
    WatchedRun stopped(world, scene);
    EXPECT_SAYS(stopped.steps(3), "overlap by 0.6");
}

} // namespace
} // namespace nappe
