// The residual, and the knobs of the solver: sweeps, tolerance, substeps.

#include "support/serial_run.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace nappe::test::solver_test {
namespace {

constexpr double g = standard_gravity;

Residual residual_after(const Scene<2>& scene, int steps = 1) {
    SerialRun run(scene);
    run.steps(steps, true);
    return run.simulation().last_residual().value();
}

/// The residual of a contact is |W (r - P(r - u / W))| over V (docs/notation.md). A disk that slides on a floor, with no sweep at all:
/// r = 0 and u is the free velocity (u_n = -g h, u_t = -v0). Then P has r_n = m g h and, sliding, |r_t| = mu m g h; W_nn = 1/m and
/// W_tt = 3/m make it g h sqrt(1 + 9 mu²). V is the larger of h g and the free velocity at the touching contact.
TEST(Residual, HandComputedOnAnUnsolvedContact) {
    const double h = 0.01, r = 0.5, v0 = 2, mu = 0.3;
    SceneBuilder sliding(mu), resting(mu);
    sliding.floor().grain(r, {0, r}, {v0, 0}).stage(solver(h, 0));
    const auto found = residual_after(sliding.scene());
    const double expected = g * h * std::sqrt(1 + 9 * mu * mu) / std::sqrt(g * g * h * h + v0 * v0);
    EXPECT_NEAR(found.largest, expected, 1e-14);
    EXPECT_NEAR(found.rms, expected, 1e-14) << "of one contact";
    resting.floor().grain(r, {0, r}).stage(solver(h, 0));
    EXPECT_NEAR(residual_after(resting.scene()).largest, 1, 1e-14) << "g h over V = g h";
}

/// Two contacts, one of which is solved by its single sweep: the RMS counts both.
TEST(Residual, RmsIsOverAllActiveContacts) {
    const double h = 0.01, r = 0.5;
    SceneBuilder b(0.3);
    b.floor().grain(r, {0, r}).grain(r, {0, 3 * r}).stage(solver(h, 0));
    // Unsolved: the floor's contact is off by g h, that between the two falling disks by nothing. V = g h.
    const auto found = residual_after(b.scene());
    EXPECT_NEAR(found.largest, 1, 1e-13);
    EXPECT_NEAR(found.rms, std::sqrt(0.5), 1e-13);
}

TEST(Residual, ZeroOnASolvedContact) {
    SceneBuilder b(0.3);
    b.floor().grain(0.5, {0, 0.5}, {2, 0}).stage(solver(0.01, 1));
    EXPECT_LE(residual_after(b.scene()).largest, 1e-14);
}

/// A driven wall sets the scale, where it is faster than what falls and slips.
TEST(Residual, ScaleIsTheDrivenWalls) {
    const double h = 0.01, r = 0.5, v = 7;
    Motion<2> motion;
    motion.velocity = {0, -v}; // away from everything
    SceneBuilder b(0.3);
    b.floor().moving_wall("lift", {{50, 0}, {60, 0}}, motion).grain(r, {0, r}).stage(solver(h, 0));
    EXPECT_NEAR(residual_after(b.scene()).largest, g * h / v, 1e-14);
}

/// A cold pile: the first step of a deposit, which has never been solved.
Scene<2> cold_pile(const SolverSettings& settings) {
    SceneBuilder b(0.4);
    b.box(8, 4, {RadiusLaw::Kind::uniform, 0.3, 0.4}, 5).stage(settings);
    return b.scene();
}

/// More sweeps, less residual: the RMS at each fourfold, the largest over each sixteenfold (one contact may rise for a while).
TEST(Residual, FallsWithSweepsInAPile) {
    std::vector<Residual> found;
    for (int sweeps = 1; sweeps <= 4096; sweeps *= 4) {
        found.push_back(residual_after(cold_pile(solver(5e-3, sweeps))));
    }
    for (std::size_t k = 1; k < found.size(); ++k) {
        EXPECT_LT(found[k].rms, found[k - 1].rms) << k;
        EXPECT_LE(found[k].rms, found[k].largest);
        if (k > 1) {
            EXPECT_LT(found[k].largest, found[k - 2].largest) << k;
        }
    }
    EXPECT_LT(found.back().largest, 1e-3 * found.front().largest);
}

TEST(Tolerance, StopsFourSweepsAfterTheFirstCheckThatMeetsIt) {
    auto settings = solver(5e-3, 10);
    settings.tolerance = 1e-3;
    settings.max_sweeps = 100'000;
    settings.check_every = 7;
    SerialRun run(cold_pile(settings));
    run.steps(1, true);
    const int sweeps = run.simulation().last_sweeps();
    const int check = sweeps - 4;
    EXPECT_EQ(check % 7, 0);
    EXPECT_LE(residual_after(cold_pile(solver(5e-3, check))).largest, 1e-3);
    EXPECT_GT(sweeps, 14) << "the case is not a trivial one";
    EXPECT_EQ(run.simulation().counters().unconverged, 0);
    EXPECT_EQ(run.simulation().counters().sweeps, sweeps);
    EXPECT_GT(residual_after(cold_pile(solver(5e-3, check - 7))).largest, 1e-3) << "it could have stopped before";
    EXPECT_EQ(residual_after(cold_pile(solver(5e-3, sweeps))).largest, run.simulation().last_residual()->largest);
}

TEST(Tolerance, SweepsAreTheLeastAndMaxSweepsTheMost) {
    auto settings = solver(5e-3, 25);
    settings.tolerance = 1e3; // met at once
    settings.check_every = 10;
    SerialRun easy(cold_pile(settings));
    easy.steps(1);
    EXPECT_EQ(easy.simulation().last_sweeps(), 34) << "the first check from 25 on, at 30, acts four sweeps later";
    EXPECT_EQ(easy.simulation().counters().unconverged, 0);

    settings.tolerance = 1e-15; // never met
    settings.max_sweeps = 33;
    SerialRun hard(cold_pile(settings));
    hard.steps(2, true);
    EXPECT_EQ(hard.simulation().last_sweeps(), 33);
    EXPECT_EQ(hard.simulation().counters().unconverged, 2) << "never silent";
    EXPECT_EQ(hard.simulation().counters().sweeps, 66);
}

TEST(Tolerance, AFixedNumberOfSweepsIsKept) {
    SerialRun run(cold_pile(solver(5e-3, 17)));
    run.steps(3);
    EXPECT_EQ(run.simulation().last_sweeps(), 17);
    EXPECT_EQ(run.simulation().counters().sweeps, 3 * 17);
    EXPECT_EQ(run.simulation().counters().unconverged, 0) << "nothing was asked";
    EXPECT_FALSE(run.simulation().last_residual().has_value());
}

/// n substeps are n steps of h / n with their share of the sweeps: the same bits (h is a power of two, so that h / n is exact).
TEST(Substeps, AreStepsOfAShorterH) {
    const double h = 0x1p-7;
    auto settings = solver(h, 40);
    settings.substeps = 4;
    SerialRun coarse(cold_pile(settings)), fine(cold_pile(solver(h / 4, 10)));
    coarse.steps(10);
    fine.steps(40);
    EXPECT_EQ(coarse.simulation().state_hash(), fine.simulation().state_hash());
    EXPECT_EQ(coarse.simulation().counters().sweeps, fine.simulation().counters().sweeps);
    EXPECT_DOUBLE_EQ(coarse.simulation().time(), fine.simulation().time());
    EXPECT_EQ(coarse.simulation().counters().steps, 10);
}

TEST(Substeps, RoundTheirSweepsUp) {
    auto settings = solver(5e-3, 10);
    settings.substeps = 4;
    SerialRun run(cold_pile(settings));
    run.steps(1);
    EXPECT_EQ(run.simulation().counters().sweeps, 4 * 3);
}

/// A stage with another h keeps forces: impulses are scaled with h, so that a resting column needs no sweep to go on resting.
TEST(Stages, KeepForcesWhenHChanges) {
    SceneBuilder b(0.4);
    const double r = 0.5;
    b.floor();
    for (int k = 0; k < 5; ++k) {
        b.grain(r, {0, r * (2 * k + 1)});
    }
    b.stage(solver(0.01, 2000)).stage(solver(0.0025, 0));
    SerialRun run(b.scene());
    run.steps(2);
    run.simulation().start_stage(1);
    run.steps(1);
    EXPECT_NEAR(run.normal_impulse(0, wall_id(0)), 5 * disk_mass(r) * g * 0.0025, 1e-9 * disk_mass(r));
    EXPECT_NEAR(run.grain(4).v[1], 0, 1e-12);
}

} // namespace
} // namespace nappe::test::solver_test
