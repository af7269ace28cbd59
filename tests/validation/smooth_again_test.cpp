// Smooth steps that are done again, or not at all: springs are stretched once.
#include "core/error.hpp"
#include "support/smooth_run.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace nappe::test::smooth {
namespace {

/// A disk that sticks to a floor which is driven along; far away another grain does what steps are done again for.
class DoneAgain : public testing::Test {
protected:
    DoneAgain() : b_(1e3) {
        Motion<2> along;
        along.stage = 0;
        along.velocity = {speed, 0};
        b_.moving_wall("floor", {{-100, 0}, {100, 0}}, along);
        b_.grain(r, {0, r - m * g / k}).material("other");
    }

    /// The spring of what sticks is stretched by the way of the floor under the rim, however often steps were done.
    /// Springs go by velocities of half a step ago: by positions where the last (sub)step began.
    void expect_stretched_once(WorldRun& run, double last) {
        const double h = run.simulation().settings().h / run.simulation().settings().substeps;
        const auto disk = run.grain(0);
        const double slip = disk.x[0] + r * disk.rotation[0] - run.simulation().walls().offset[0][0] -
                            last * (disk.v[0] + run.rim_speed(0) - speed);
        double s = 0;
        for (const auto& contact : run.loaded_contacts()) {
            s = contact.lo == 0 ? contact.r_t[0] / h : s;
        }
        // The tangent of a floor below points along -x.
        EXPECT_NEAR(s, k_s * slip, 1e-9 * k_s * speed / w_t);
        EXPECT_GT(std::abs(slip), 0.01 * speed / w_t);
    }

    static constexpr double speed = 0.01, k_s = 1e5;
    const double w_t = std::sqrt(3 * k_s / m), h = 0.05 / w_t;
    SceneBuilder b_;
};

TEST_F(DoneAgain, SpringsAreStretchedOnceWhereListsFallShort) {
    // A fast grain strikes one at rest, which goes farther in a step than its margin.
    for (int i = 0; i < 6; ++i) {
        b_.grain(r, {20 + 2.01 * r * i, 20}, {i == 0 ? 5.0 : 0.0, 0});
    }
    b_.stage(smooth_settings(h));
    auto scene = with_springs(b_, k_s);
    scene.tiles.skin = 1e-5;
    scene.tiles.lookahead = 0.1;
    WorldRun run(scene);
    int seen = 0;
    for (int n = 0; n < 60; ++n) {
        const auto before = run.simulation().counters().redone_lists;
        run.steps(1);
        seen += run.simulation().counters().redone_lists > before ? 1 : 0;
        if (n > 20) {
            expect_stretched_once(run, h);
        }
    }
    EXPECT_GT(seen, 3) << "no step was done again: the case is none";
}

/// So fast that tiles allow it only in steps divided `times`.
Scene<2> with_a_fast_grain(Scene<2> scene, double h, double times) {
    scene.tiles.side = 4;
    scene.grains[1].velocity = {0.6 * times * (4 / 4.0 - r) / h, 0};
    scene.watch.failure = WatchSettings<2>::Then::substep;
    return scene;
}

TEST_F(DoneAgain, SpringsAreStretchedOnceWhereStepsAreDivided) {
    b_.grain(r, {-1000, 50}, {0, 0}).stage(smooth_settings(h));
    for (const int times : {2, 4, 8}) {
        WorldRun run(with_a_fast_grain(with_springs(b_, k_s), h, times));
        for (int n = 0; n < 60; ++n) {
            run.steps(1);
            if (n > 20) {
                expect_stretched_once(run, h / times);
            }
        }
        EXPECT_GT(run.simulation().watcher().memory().divided_steps, 30) << "no step was divided: the case is none";
        EXPECT_EQ(run.simulation().watcher().memory().most_substeps, times);
    }
}

TEST_F(DoneAgain, SpringsAreThoseOfTheStartWhereNoDivisionHelps) {
    b_.grain(r, {-1000, 50}, {0, 0}).stage(smooth_settings(h));
    auto scene = with_a_fast_grain(with_springs(b_, k_s), h, 1);
    scene.watch.max_substeps = 8;
    WorldRun run(scene);
    run.steps(20);
    auto rows = run.simulation().grain_rows();
    for (auto& row : rows) { // a push that eight substeps do not tell apart
        row.v[0] = row.id == 1 ? 100 * row.v[0] : row.v[0];
    }
    auto& simulation = run.simulation();
    simulation.load(rows, simulation.contact_rows(), h);
    simulation.start_stage(0);
    const auto springs = simulation.comm().all_gather(simulation.contact_rows());
    EXPECT_THROW(simulation.step(), NumericalFailure);
    ASSERT_TRUE(simulation.undo_step());
    const auto after = simulation.comm().all_gather(simulation.contact_rows());
    ASSERT_EQ(after.size(), springs.size());
    ASSERT_GT(springs.size(), 0u);
    for (std::size_t k = 0; k < springs.size(); ++k) {
        EXPECT_EQ(after[k].r_t[0], springs[k].r_t[0]);
        EXPECT_NE(springs[k].r_t[0], 0);
    }
}

} // namespace
} // namespace nappe::test::smooth
