// Where energy goes while contacts are smooth: single losses by formula, the balance of all of them to round-off on any
// number of ranks, and what the watch makes of it.
#include "solver/smooth_energy.hpp"

#include "support/serial_run.hpp"
#include "support/watched_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace nappe::test::smooth_energy_test {
namespace {

constexpr double g = standard_gravity, pi = std::numbers::pi;
constexpr double r = 0.5, k = 4e6;
const double m = disk_mass(r);

Scene<2>& with_springs(SceneBuilder& b, double k_s, std::optional<double> c_n, std::optional<double> c_s) {
    for (auto& law : b.scene().laws) {
        law.springs = Springs{{k, c_n}, {k_s, c_s}};
    }
    b.scene().output.measures.energy = true;
    return b.scene();
}

/// A scene on all ranks, whose energy is counted from its start.
class CountedRun {
public:
    explicit CountedRun(const Communicator& comm, const Scene<2>& scene) : comm_(comm), run_(comm, scene) {
        run_.simulation().mark_cells();
        kinetic_ = energies(run_.simulation()).kinetic;
    }

    void steps(std::int64_t n) { ASSERT_EQ(run_.steps(n), ""); }

    EnergyBudget budget() {
        auto sums = run_.simulation().energy();
        sums.for_each_sum([&](ExactSum& sum) { comm_.sum(sum.limbs()); });
        return sums.budget();
    }
    double wall_work() {
        auto sums = run_.simulation().sums();
        sums.for_each_sum([&](ExactSum& sum) { comm_.sum(sum.limbs()); });
        return sums.wall_work();
    }
    double gain() { return energies(run_.simulation()).kinetic - kinetic_; }
    double error() {
        const auto b = budget();
        return gain() - (b.gravity + b.theta_term + wall_work() - b.lost());
    }
    WatchedRun& run() { return run_; }

private:
    const Communicator& comm_;
    WatchedRun run_;
    double kinetic_ = 0;
};

class SmoothEnergy : public WatchTest {};

/// Falls on through a medium: v = m g / C, and damping takes what gravity does, C v² = m g v.
TEST_F(SmoothEnergy, GlobalDampingEatsTheWorkOfGravity) {
    const double h = 1e-3, c = 2 * m, v = m * g / c;
    SceneBuilder b;
    b.grain(r, {0, 0}, {0, -v}).stage(smooth_settings(h));
    b.scene().materials[0].damping = c;
    CountedRun counted(alone, with_springs(b, 0, 0, 0));
    const int n = 500;
    counted.steps(n);
    const double power = m * g * v;
    EXPECT_NEAR(counted.budget().damping, power * n * h, 1e-12 * power * n * h);
    EXPECT_NEAR(counted.budget().gravity, power * n * h, 1e-12 * power * n * h);
}

/// Spin alone: exp(-2 C* t / I) of its energy is left up to (C* h / I)², and all of it went into damping.
TEST_F(SmoothEnergy, GlobalDampingEatsSpin) {
    const double h = 1e-3, inertia = 0.5 * m * r * r, c = 0.5 * inertia, spin = 3;
    SceneBuilder b;
    b.gravity(0, 0).grain(r, {0, 0}, {0, 0}, spin).stage(smooth_settings(h));
    b.scene().materials[0].spin_damping = c;
    CountedRun counted(alone, with_springs(b, 0, 0, 0));
    counted.steps(1000);
    const double before = 0.5 * inertia * spin * spin;
    EXPECT_NEAR(counted.budget().damping, before * (1 - std::exp(-1.0)), 1e-6 * before);
    EXPECT_NEAR(counted.error(), 0, 1e-12 * before);
}

/// Thrown along a floor, pressed by its weight: slip is v0 - 3 mu g t, its way v0 T - (3/2) mu g T² to the end of its steps
/// (means of velocities that are linear in time), and friction takes mu m g times that. Springs get nothing but what the
/// first step stretches them by. A dashpot beside the spring that slides changes nothing; without a spring it is the
/// dashpot that the limit cuts, to mu m g / (c_s v) of what it would pull.
TEST_F(SmoothEnergy, FrictionIsWeightTimesWay) {
    const double mu = 0.3, v0 = 5, w = std::sqrt(k / m), h = 0.02 / w, limit = mu * m * g;
    const int n = 200;
    const double t = n * h, way = v0 * t - 1.5 * mu * g * t * t;
    for (const auto& [k_s, c_s] :
         {std::pair(k, 0.0), std::pair(k, 2 * std::sqrt(k * m)), std::pair(0.0, 1e3 * limit)}) {
        SceneBuilder b(mu);
        b.floor(1000).grain(r, {0, r - m * g / k}, {v0, 0}).stage(smooth_settings(h));
        CountedRun counted(alone, with_springs(b, k_s, 0, c_s));
        counted.steps(n);
        const auto found = counted.budget();
        // Energy of a spring at its limit, and the way until it is there; a dashpot's own share of the way: limit / (c_s v).
        const double stretching = k_s > 0 ? limit * limit / k_s : limit * t * limit / c_s;
        EXPECT_NEAR(found.friction, limit * way, 2 * stretching + 1e-9 * limit * way) << k_s;
        EXPECT_LT(stretching, 0.01 * limit * way);
        EXPECT_NEAR(counted.error(), 0, 1e-12 * limit * way);
        EXPECT_NEAR(found.dashpot, k_s > 0 ? 0.0 : stretching, k_s > 0 ? stretching : 0.2 * stretching) << k_s;
        EXPECT_NEAR(found.spring, 0, 2 * stretching + 1e-9 * limit * way) << k_s;
    }
}

/// Head on: the dashpot takes 1 - e² of the relative energy, e of a damped oscillator; springs give back what they got.
TEST_F(SmoothEnergy, DashpotTakesWhatTheReboundLacks) {
    const double w = std::sqrt(2 * k / m), v0 = 0.1, zeta = 0.2, energy = 0.25 * m * v0 * v0;
    const double e = std::exp(-pi * zeta / std::sqrt(1 - zeta * zeta));
    for (const double wh : {0.02, 0.005}) {
        const double h = wh / w;
        SceneBuilder b;
        b.gravity(0, 0).grain(r, {0, 0}, {v0, 0}).grain(r, {2 * r, 0}).stage(smooth_settings(h));
        CountedRun counted(alone, with_springs(b, 0, 2 * zeta * w * m / 2, 0));
        counted.steps(static_cast<int>(8 / wh));
        EXPECT_NEAR(counted.budget().dashpot, energy * (1 - e * e), wh * energy) << wh; // of first order, as e itself
        EXPECT_NEAR(counted.budget().spring, 0, wh * energy);
        EXPECT_NEAR(counted.gain() + counted.budget().dashpot + counted.budget().spring, 0, 1e-12 * energy);
    }
}

/// A disk falls on a floor and the floor drags it: while nothing slides, what works say of springs is what they hold.
TEST_F(SmoothEnergy, SpringsHoldWhatWasPutIntoThem) {
    const double w = std::sqrt(k / m), v0 = 0.5, energy = 0.5 * m * v0 * v0;
    for (const double wh : {0.02, 0.005}) {
        SceneBuilder b(1e3);
        b.gravity(0, 0).floor().grain(r, {0, r}, {0.1, -v0}).stage(smooth_settings(wh / w));
        CountedRun counted(alone, with_springs(b, 0.25 * k, 0, 0));
        for (int i = 1; i * wh < 3; ++i) {
            counted.steps(1);
            const double held = elastic_energy(counted.run().simulation());
            // Positions are half a step later than velocities, a tangential spring half a step earlier: w h / 2 of all.
            EXPECT_NEAR(counted.budget().spring, held, wh * energy) << i;
            EXPECT_EQ(counted.budget().dashpot, 0);
        }
        EXPECT_GT(counted.budget().spring, 0) << "it has left the floor: the case is none";
    }
}

/// Grains that fall on each other between walls, one of which is pushed in and stops; all that takes energy is there.
Scene<2> heap() {
    SceneBuilder b(0.3);
    b.box(12, 6, {RadiusLaw::Kind::uniform, 0.15, 0.25}, 5).grain(0.25, {6, 8}, {0.5, -6}, 20);
    Motion<2> motion;
    motion.velocity = {0.7, 0.1};
    motion.start = 0.02;
    motion.stop = 0.06;
    b.scene().walls[1].motion = motion;
    b.stage(smooth_settings(2e-4));
    for (auto& law : b.scene().laws) {
        law.springs = Springs{{2e6, 400}, {1e6, 200}};
    }
    b.scene().materials[0].damping = 30;
    b.scene().materials[0].spin_damping = 0.5;
    auto scene = b.scene();
    scene.tiles.side = 1.5;
    scene.output.measures.energy = true;
    return scene;
}

/// Tolerance: a grain's velocity is rounded at each of its contacts and twice beside, by up to 1e-16 of it a time: 1e-15 of
/// the energy that passes through a step, and steps add up at most linearly, as works do. 1e-12 of all work leaves a factor
/// of a thousand for parts that cancel within a step.
TEST_F(SmoothEnergy, ClosesToRoundOffOnAnyNumberOfRanks) {
    CountedRun counted(world, heap()), single(alone, heap());
    double passed = 0;
    for (int i = 0; i < 8; ++i) {
        counted.steps(50);
        single.steps(50);
        const auto b = counted.budget(), of_one = single.budget();
        passed = std::abs(b.gravity) + std::abs(counted.wall_work()) + std::abs(b.friction) + std::abs(b.spring) +
                 std::abs(b.dashpot) + b.damping;
        EXPECT_LT(std::abs(counted.error()), 1e-12 * passed);
        for (const auto of : {&EnergyBudget::gravity, &EnergyBudget::theta_term, &EnergyBudget::friction,
                              &EnergyBudget::spring, &EnergyBudget::dashpot, &EnergyBudget::damping}) {
            EXPECT_EQ(b.*of, of_one.*of);
        }
        EXPECT_EQ(b.impact, 0);
        EXPECT_EQ(b.cohesion, 0);
    }
    const auto b = counted.budget(); // each has its part, or the balance says nothing of it
    for (const double part : {b.friction, b.spring, b.dashpot, b.damping, std::abs(counted.wall_work())}) {
        EXPECT_GT(part, 1e-3 * passed);
    }
    EXPECT_GT(counted.run().simulation().counters().rebuilds, 2);
    EXPECT_EQ(counted.run().found(Watched::energy), 0);
}

/// A spring gives back in a step far more than the limit, which is no growth. What is: the last force acts past the opening, by
/// (w h)²/4 of the energy at most, 0.04 with the longer step here; with a step too long for the spring, all of it.
TEST_F(SmoothEnergy, WatchCountsWhatSpringsHold) {
    const double critical = 2 * std::sqrt(m / (2 * k)); // of m_eff = m/2
    const auto at = [&](double share) {
        SceneBuilder b(0.3);
        b.gravity(0, 0).grain(r, {0, 0}, {0.5, 0}).grain(r, {2 * r, 0}, {-0.5, 0}).grain(r, {40, 0});
        b.stage(smooth_settings(share * critical));
        auto scene = with_springs(b, 0, 0, 0);
        scene.watch.energy.limit = 0.05;
        return scene;
    };
    for (const double share : {0.1, 0.2}) {
        WatchedRun run(alone, at(share));
        double before = energies(run.simulation()).kinetic, most = 0;
        EXPECT_EQ(run.steps(60,
                            [&] {
                                const double now = energies(run.simulation()).kinetic;
                                most = std::max(most, (now - before) / before);
                                before = now;
                            }),
                  "");
        EXPECT_GT(most, 0.1) << "no spring gave much: the case is none";
        EXPECT_EQ(run.found(Watched::energy), 0) << share;
    }
    // The whole velocity goes into the overlap in one step and comes back 4 share² - 1 fold.
    WatchedRun run(alone, at(1.2));
    EXPECT_EQ(run.steps(10), "");
    EXPECT_GT(run.found(Watched::energy), 0);
    EXPECT_GT(run.memory().largest_growth, 1);
    ASSERT_FALSE(run.lines.empty());
    EXPECT_SAYS(run.lines[0], "most of it between grains 0 and 1");
}

/// Falls: nothing balances its weight. On the floor: k d does.
TEST_F(SmoothEnergy, UnbalancedForceOfOneDisk) {
    SceneBuilder b;
    b.grain(r, {0, 5}).floor().stage(smooth_settings(1e-4));
    b.scene().materials[0].damping = 50;
    WatchedRun falls(alone, with_springs(b, 0, 0, 0));
    EXPECT_EQ(falls.steps(100), "");
    EXPECT_NEAR(unbalanced_force(falls.simulation()), 1, 1e-9);
    b.scene().grains[0].position = {0, r - 0.5 * m * g / k}; // half of its weight: of 3/2 weights, 1/2 is not balanced
    WatchedRun rests(alone, b.scene());
    EXPECT_EQ(rests.steps(1), "");
    EXPECT_NEAR(unbalanced_force(rests.simulation()), 1.0 / 3, 1e-9);
}

/// A disk on another: m g between them holds the upper one, the floor bears as much and would have to bear twice that. Of the
/// forces, two weights, the pair's on each of the two and the floor's, one in five is not balanced.
TEST_F(SmoothEnergy, UnbalancedForceOfAPairCountsItsForceOnBoth) {
    const double d = m * g / k;
    SceneBuilder b;
    b.grain(r, {0, r - d}).grain(r, {0, 3 * r - 2 * d}).floor().stage(smooth_settings(1e-4));
    WatchedRun run(alone, with_springs(b, 0, 0, 0));
    EXPECT_EQ(run.steps(1), "");
    EXPECT_NEAR(unbalanced_force(run.simulation()), 0.2, 1e-9);
}

/// A disk whose weight is borne, and that is held back by a tangential spring, stretched by v h in the first step.
TEST_F(SmoothEnergy, UnbalancedForceKnowsFriction) {
    const double h = 1e-4, share = 0.3;
    SceneBuilder b(0.5);
    b.grain(r, {0, r - m * g / k}, {share * m * g / (k * h), 0}).floor().stage(smooth_settings(h));
    WatchedRun run(alone, with_springs(b, k, 0, 0));
    EXPECT_EQ(run.steps(1), "");
    EXPECT_NEAR(unbalanced_force(run.simulation()), share / (1 + std::hypot(1, share)), 1e-9);
}

/// Forces are summed over ranks.
TEST_F(SmoothEnergy, UnbalancedForceIsTheSameOnAnyNumberOfRanks) {
    SceneBuilder b(0.4);
    b.box(12, 4, {RadiusLaw::Kind::uniform, 0.15, 0.25}, 5).stage(smooth_settings(2e-4));
    b.scene().tiles.side = 1.5;
    auto& scene = with_springs(b, 0.5 * k, {}, {});
    WatchedRun run(world, scene), one(alone, scene);
    ASSERT_EQ(run.steps(50), "");
    ASSERT_EQ(one.steps(50), "");
    EXPECT_EQ(unbalanced_force(run.simulation()), unbalanced_force(one.simulation()));
    EXPECT_GT(unbalanced_force(one.simulation()), 0.01);
}

} // namespace
} // namespace nappe::test::smooth_energy_test
