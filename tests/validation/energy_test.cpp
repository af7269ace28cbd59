// Where energy goes: single losses by formula, and the balance of all of them to round-off.
#include "support/serial_run.hpp"

#include <gtest/gtest.h>

namespace nappe::test::energy_test {
namespace {

/// A run whose energy is counted from its start.
class CountedRun {
public:
    explicit CountedRun(Scene<2> scene) : run_(with_budget(std::move(scene))) {
        run_.simulation().mark_cells();
        at_start_ = energies(run_.simulation());
    }

    void steps(std::int64_t n) { run_.steps(n); }

    EnergyBudget budget() { return run_.simulation().energy().budget(); }
    double wall_work() { return run_.simulation().sums().wall_work(); }
    double kinetic() { return energies(run_.simulation()).kinetic; }
    double kinetic_gain() { return kinetic() - at_start_.kinetic; }
    double potential_loss() { return at_start_.potential - energies(run_.simulation()).potential; }

    double error() {
        const auto b = budget();
        return kinetic_gain() - (b.gravity + b.theta_term + wall_work() - b.friction - b.impact - b.cohesion);
    }

    SerialRun& run() { return run_; }

private:
    static Scene<2> with_budget(Scene<2> scene) {
        scene.output.measures.energy = true;
        return scene;
    }

    SerialRun run_;
    Energies at_start_;
};

/// A disk thrown along a floor slides until it rolls at 2/3 of its speed (docs: validation, slide to roll): of
/// m v0²/2 it keeps 3/2 (2/3)² = 2/3, so friction takes a third. The normal contact takes nothing.
TEST(Energy, FrictionOfSlideToRoll) {
    SceneBuilder builder(0.4);
    builder.floor().grain(0.5, {0, 0.5}, {3, 0}).stage(solver(1e-3, 50));
    CountedRun counted(builder.scene());
    counted.steps(500); // v0 / (3 mu g) = 0.25 s
    const double before = 0.5 * disk_mass(0.5) * 9;
    EXPECT_NEAR(counted.budget().friction, before / 3, 1e-12 * before);
    EXPECT_NEAR(counted.budget().impact, 0, 1e-12 * before);
    EXPECT_EQ(counted.budget().cohesion, 0);
}

/// Newton's law of impact: of m v²/2 the contact takes the part 1 − e².
TEST(Energy, ImpactOfAHeadOnMeeting) {
    const double e = 0.6, v = 1.5, m = disk_mass(0.5);
    SceneBuilder builder(0, e);
    builder.gravity(0, 0).grain(0.5, {-0.51, 0}, {v, 0}).grain(0.5, {0.51, 0}, {-v, 0}).stage(solver(1e-2, 50));
    CountedRun counted(builder.scene());
    counted.steps(10);
    EXPECT_NEAR(counted.budget().impact, m * v * v * (1 - e * e), 1e-12 * m * v * v);
    EXPECT_EQ(counted.budget().friction, 0);
    EXPECT_NEAR(counted.error(), 0, 1e-12 * m * v * v);
}

/// Two disks that part against their bond: it pulls with gamma from touch until the end of the step that passes d_w, so it
/// takes gamma d_w, and for at most a step more.
TEST(Energy, CohesionTakesTheWorkOfTheBond) {
    const double gamma = 1e4, d_w = 0.05, v = 2, h = 1e-4;
    SceneBuilder builder;
    builder.gravity(0, 0).cohesion(0, 0, gamma, d_w);
    builder.grain(0.5, {0, 0}, {-v, 0}).grain(0.5, {1, 0}, {v, 0}).stage(solver(h, 20));
    CountedRun counted(builder.scene());
    counted.steps(200); // 2 v of 0.02 s is 0.08 m
    EXPECT_GT(counted.budget().cohesion, gamma * d_w * (1 - 1e-12));
    EXPECT_LT(counted.budget().cohesion, gamma * (d_w + 2 * v * h));
    EXPECT_NEAR(counted.kinetic_gain(), -counted.budget().cohesion, 1e-12 * disk_mass(0.5) * v * v);
    EXPECT_EQ(counted.budget().impact, 0);
}

/// Cohesive grains pushed by a wall: the balance closes to the round-off of its terms.
TEST(Energy, BalanceWithCohesion) {
    for (const int kept : {1, 4}) {
        auto settings = solver(0.01, 20);
        settings.substeps = settings.geometry_every = kept;
        SceneBuilder builder(0.4);
        builder.box(4, 3, {RadiusLaw::Kind::uniform, 0.13, 0.26}).cohesion(0, 0, 1e4, 0.01).stage(settings);
        builder.scene().walls[1].motion = Motion<2>{{0.5, 0.3}, 0, 0, {}};
        CountedRun counted(builder.scene());
        counted.steps(200);
        EXPECT_GT(counted.budget().cohesion, 0);
        EXPECT_NEAR(counted.error(), 0, 1e-12 * std::abs(counted.wall_work())) << kept;
    }
}

/// A wall that starts at V takes the disk in front of it along: all its work is the disk's m V²/2, none is lost. (By
/// the wall's new velocity alone it would be m V².) Stopping, it loses the disk and does no more.
TEST(Energy, WorkOfAWallThatStartsAndStops) {
    const double speed = 0.8;
    Motion<2> motion;
    motion.velocity = {speed, 0};
    motion.start = 0.1;
    motion.stop = 0.3;
    for (const int kept : {1, 4}) { // substeps that share a geometry: the wall starts in the first of a step
        auto settings = solver(1e-2, 20);
        settings.substeps = settings.geometry_every = kept;
        SceneBuilder builder;
        builder.gravity(0, 0).moving_wall("piston", {{0, -2}, {0, 2}}, motion).grain(0.5, {0.5, 0}).stage(settings);
        CountedRun counted(builder.scene());
        counted.steps(60);
        const double gain = 0.5 * disk_mass(0.5) * speed * speed;
        EXPECT_NEAR(counted.kinetic(), gain, 1e-12 * gain) << kept;
        EXPECT_NEAR(counted.wall_work(), gain, 1e-12 * gain) << kept;
        EXPECT_NEAR(counted.budget().impact, 0, 1e-12 * gain) << kept;
    }
}

/// Theta-scheme without contacts: after n steps a disk at rest has v = n h g and has gone h² g (n²/2 + (theta − 1/2) n)
/// (sum of theta v_k+1 + (1 − theta) v_k): the last term's work does not reach v.
TEST(Energy, ThetaTermOfFreeFall) {
    const double h = 0.01, theta = 0.8, g = standard_gravity, m = disk_mass(0.5);
    SceneBuilder builder;
    builder.grain(0.5, {0, 0}).stage(solver(h, 10, theta));
    CountedRun counted(builder.scene());
    counted.steps(40);
    const double scale = m * h * h * g * g;
    EXPECT_NEAR(counted.budget().gravity, scale * (800 + 0.3 * 40), 1e-10 * scale);
    EXPECT_NEAR(counted.budget().theta_term, -scale * 0.3 * 40, 1e-10 * scale);
    EXPECT_NEAR(counted.kinetic(), scale * 800, 1e-10 * scale);
}

struct Case {
    const char* name;
    double theta;
    double restitution;
    int substeps;
    int sweeps;
};

class Balance : public testing::TestWithParam<Case> {};

/// A deposit falls together in a box one of whose walls is pushed in, stops and is never pushed back. Few sweeps: the
/// balance asks for no convergence. Tolerance: each relaxation rounds a velocity once, some 1e2 relaxations of a grain
/// a step, each by up to 1e-16 of it: 1e-14 of the energy that passes through a step, and steps add up at most
/// linearly, as works do. 1e-12 of all work leaves a factor of a hundred for parts that cancel within a step.
TEST_P(Balance, ClosesToRoundOff) {
    const auto& with = GetParam();
    SceneBuilder builder(0.4, with.restitution);
    builder.box(6, 4, {RadiusLaw::Kind::uniform, 0.2, 0.3});
    Motion<2> motion;
    motion.velocity = {0.7, 0.1};
    motion.start = 0.2;
    motion.stop = 0.9;
    builder.scene().walls[1].motion = motion;
    auto settings = solver(0.01, with.sweeps, with.theta);
    settings.substeps = with.substeps;
    builder.stage(settings);
    CountedRun counted(builder.scene());
    double largest = 0, passed = 0;
    for (int k = 0; k < 15; ++k) {
        counted.steps(10);
        const auto b = counted.budget();
        passed = std::max(passed, std::abs(b.gravity) + std::abs(counted.wall_work()) + std::abs(b.friction) +
                                      std::abs(b.impact));
        largest = std::max(largest, std::abs(counted.error()));
    }
    const auto b = counted.budget();
    EXPECT_LT(largest, 1e-12 * passed);
    // Each has its part, or the balance says nothing of it.
    EXPECT_GT(std::abs(counted.wall_work()), 0.01 * passed);
    EXPECT_GT(b.friction, 0.01 * passed);
    EXPECT_GT(b.impact, 0.01 * passed);
    EXPECT_EQ(b.theta_term == 0, with.theta == 0.5);
    // Positions were moved by sums of as many terms of a potential that is a hundred times the work: 1e-16 each.
    EXPECT_NEAR(b.gravity, counted.potential_loss(), 1e-10 * passed);
}

INSTANTIATE_TEST_SUITE_P(Energy, Balance,
                         testing::Values(Case{"inelastic", 0.5, 0, 1, 10}, Case{"theta_1", 1, 0, 1, 10},
                                         Case{"restitution", 0.5, 0.5, 1, 10},
                                         Case{"theta_restitution_substeps", 0.7, 0.3, 3, 12}),
                         [](const auto& of) { return std::string(of.param.name); });

TEST(Energy, IsNotCountedUnlessAsked) {
    SceneBuilder builder(0.4);
    builder.floor().grain(0.5, {0, 0.5}, {3, 0}).stage(solver(1e-2, 10));
    SerialRun run(builder.scene());
    run.simulation().mark_cells();
    run.steps(5);
    EXPECT_EQ(run.simulation().energy().budget().friction, 0);
}

} // namespace
} // namespace nappe::test::energy_test
