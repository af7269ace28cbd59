// The non-smooth Lennard-Jones law (seeds/000 §4.3, fig. 3; reading in docs/notation.md) against statics, energy and its
// own graph.

#include "support/serial_run.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <random>

namespace nappe::test::cohesion_test {
namespace {

constexpr double r = 0.5, g = standard_gravity, h = 1e-3;
const double weight = disk_mass(r) * g;

/// Grains 0 … n-1, the lowest first, in a column that hangs from a ceiling (wall 0, material 1).
SceneBuilder hanging_column(int n, double gamma, double gamma_of_ceiling, double d_w) {
    SceneBuilder scene;
    const int top = scene.material("ceiling");
    scene.law(0, top, 0).cohesion(0, 0, gamma, d_w).cohesion(0, top, gamma_of_ceiling, d_w);
    scene.wall("ceiling", {{-5, 0}, {5, 0}}, top);
    for (int k = 0; k < n; ++k) {
        scene.grain(r, {0, -r - 2 * r * (n - 1 - k)});
    }
    scene.stage(solver(h, 200));
    return scene;
}

TEST(Cohesion, OneGrainHangsIfTheBondIsStrongerThanItsWeight) {
    SerialRun run(hanging_column(1, 0, 1.001 * weight, 0.01).scene());
    run.steps(1000);
    EXPECT_NEAR(run.grain(0).x[1], -r, 1e-12) << "a contact that holds does not creep";
    EXPECT_NEAR(run.normal_impulse(0, wall_id(0)), -weight * h, 1e-9 * weight * h) << "the bond carries the weight";
}

TEST(Cohesion, OneGrainFallsIfItIsWeakerByHowMuchItIsWeaker) {
    // Up to d_w the bond pulls with gamma: acceleration g - gamma/m = g/1000; the fall from d_w on is free. 2,000 steps
    // of 1 ms: 0.5 (g/1000) 4 s² = 0.0196 m, more than d_w = 0.01 m, which is left after sqrt(2 d_w/(g/1000)) = 1.4278 s
    // with 0.01401 m/s. The step in which it is left is known to one step: h of g in velocity.
    SerialRun run(hanging_column(1, 0, 0.999 * weight, 0.01).scene());
    run.steps(1400);
    EXPECT_NEAR(run.grain(0).v[1], -0.001 * g * 1.4, 1e-9);
    run.steps(600);
    const double left = std::sqrt(2 * 0.01 / (0.001 * g));
    EXPECT_NEAR(run.grain(0).v[1], -0.001 * g * left - g * (2.0 - left), 1.01 * g * h);
}

TEST(Cohesion, AColumnBreaksWhereTheLoadExceedsTheBond) {
    // Contact k from below carries k weights: six grains need 6 at the ceiling. 100 gives time to fall visibly.
    const int n = 6;
    SerialRun holds(hanging_column(n, 6.01 * weight, 6.01 * weight, 0.01).scene());
    holds.steps(1000);
    for (int k = 0; k < n; ++k) {
        EXPECT_NEAR(holds.grain(k).x[1], -r - 2 * r * (n - 1 - k), 1e-6) << k;
        // 200 sweeps over 6 contacts: converged.
        EXPECT_NEAR(holds.normal_impulse(k, k + 1 < n ? k + 1 : wall_id(0)), -(k + 1) * weight * h, 1e-6 * weight * h)
            << k;
    }
    // At the ceiling nothing but the bond is weaker: all six go, and stay together, since a column pulled back by gamma at
    // its top falls with a = g - gamma/(6 m), and contact k then carries k gamma/6 < gamma.
    SerialRun breaks(hanging_column(n, 5.9 * weight, 5.9 * weight, 0.01).scene());
    breaks.steps(1500);
    for (int k = 0; k < n; ++k) {
        EXPECT_LT(breaks.grain(k).x[1], -r - 2 * r * (n - 1 - k) - 0.1) << k;
    }
    for (int k = 0; k + 1 < n; ++k) {
        EXPECT_NEAR(breaks.grain(k + 1).x[1] - breaks.grain(k).x[1], 2 * r, 1e-6) << k;
    }
    // With a stronger ceiling the column parts below it: contact 5 carries five weights, gamma is 4.5.
    SerialRun parts(hanging_column(n, 4.5 * weight, 7 * weight, 0.01).scene());
    parts.steps(1000);
    EXPECT_NEAR(parts.grain(5).x[1], -r, 1e-6) << "the first hangs on";
    EXPECT_LT(parts.grain(4).x[1], -3 * r - 0.1) << "the others are gone";
    EXPECT_NEAR(parts.grain(4).x[1] - parts.grain(0).x[1], 8 * r, 1e-6) << "together";
}

TEST(Cohesion, EscapeTakesTheWorkOfTheBond) {
    // 0.5 m_eff v² against gamma d_w. Within d_w the deceleration is constant, which the scheme integrates exactly; the
    // bond is lost at the end of the step that passes d_w, so up to gamma h v of work more: h v/d_w = 0.5 %.
    const double gamma = 1e4, d_w = 0.05, m_eff = disk_mass(r) / 2;
    const double escape = std::sqrt(2 * gamma * d_w / m_eff);
    for (const double factor : {0.98, 1.02}) {
        SceneBuilder scene;
        scene.gravity(0, 0).cohesion(0, 0, gamma, d_w);
        scene.grain(r, {0, 0}, {-0.5 * factor * escape, 0}).grain(r, {2 * r, 0}, {0.5 * factor * escape, 0});
        scene.stage(solver(1e-4, 20));
        SerialRun run(scene.scene());
        run.steps(10000);
        const double gap = run.grain(1).x[0] - run.grain(0).x[0] - 2 * r;
        const double apart = run.grain(1).v[0] - run.grain(0).v[0];
        if (factor < 1) {
            EXPECT_NEAR(gap, 0, 1e-4 * escape) << "drawn back: the closing step ends within h v";
            EXPECT_NEAR(apart, 0, 1e-9) << "and stuck, without rebound";
        } else {
            EXPECT_GT(gap, d_w);
            EXPECT_NEAR(apart, escape * std::sqrt(factor * factor - 1), 0.02 * escape);
        }
    }
}

/// Two grains without gravity; the bond at the start of each step.
class Pair {
public:
    Pair(double gap, double opening_speed, double gamma, double d_w = 0.01, double step = h) {
        SceneBuilder scene;
        scene.gravity(0, 0).cohesion(0, 0, gamma, d_w);
        scene.grain(r, {0, 0}, {-0.5 * opening_speed, 0}).grain(r, {2 * r + gap, 0}, {0.5 * opening_speed, 0});
        scene.stage(solver(step, 20));
        run_.emplace(scene.scene());
    }

    /// At the start of the next step, which is done.
    Bond next() {
        run_->steps(1);
        const auto& set = run_->simulation().candidates();
        return set.size() == 1 ? set.bond[0] : Bond::none;
    }

    double r_n() { return run_->simulation().candidates().size() == 1 ? run_->simulation().candidates().r_n[0] : 0; }

private:
    std::optional<SerialRun> run_;
};

TEST(Cohesion, EveryTransitionOfTheStatusGraph) {
    const double gamma = 1e4;
    const auto path = [](Pair pair, int steps) {
        std::vector<Bond> seen{pair.next()};
        for (int k = 1; k < steps; ++k) {
            if (const Bond now = pair.next(); now != seen.back()) {
                seen.push_back(now);
            }
        }
        return seen;
    };
    using P = std::vector<Bond>;
    // Slow approach from afar: bonded at d_w, drawn in, stuck; and it stays so.
    EXPECT_EQ(path(Pair(0.02, -0.1, gamma), 2000), (P{Bond::none, Bond::cohesive, Bond::stick}));
    // However fast: a step that closes the gap ends half-way (theta = 1/2), within the range.
    EXPECT_EQ(path(Pair(0.02, -15, gamma), 10), (P{Bond::none, Bond::cohesive, Bond::stick}));
    // Within d_w at rest: drawn in.
    EXPECT_EQ(path(Pair(0.005, 0, gamma), 2000), (P{Bond::cohesive, Bond::stick}));
    // Torn off: through the range, and out.
    EXPECT_EQ(path(Pair(-1e-9, 2, gamma), 50), (P{Bond::stick, Bond::cohesive, Bond::none}));
    // In one step.
    EXPECT_EQ(path(Pair(-1e-9, 30, gamma), 10), (P{Bond::stick, Bond::none}));
    // Parted too slowly: out of touch and back.
    EXPECT_EQ(path(Pair(-1e-9, 0.3, gamma), 2000), (P{Bond::stick, Bond::cohesive, Bond::stick}));
    // Never near, and leaving.
    EXPECT_EQ(path(Pair(0.02, 0.1, gamma), 10), (P{Bond::none}));
}

TEST(Cohesion, WithinTheRangeThePullIsGammaAndNothingOutsideIt) {
    Pair open(0.005, 0.1, 1e3);
    EXPECT_EQ(open.next(), Bond::cohesive);
    EXPECT_DOUBLE_EQ(open.r_n(), -1e3 * h);
    Pair away(0.0101, 0, 1e3);
    EXPECT_EQ(away.next(), Bond::none);
    EXPECT_EQ(away.r_n(), 0);
    Pair far(0.4, 0, 1e3, 0.5); // the lists' own reach ends at 0.3
    EXPECT_EQ(far.next(), Bond::cohesive);
    Pair lost(0.0099, 0.5, 1e3); // leaves in the first step, with the pull of that step
    EXPECT_EQ(lost.next(), Bond::cohesive);
    EXPECT_DOUBLE_EQ(lost.r_n(), -1e3 * h);
    EXPECT_EQ(lost.next(), Bond::none);
    EXPECT_EQ(lost.r_n(), 0) << "a warm start must not hand on a pull that is over";
}

TEST(Cohesion, ListsReachWallsToo) {
    SceneBuilder scene = hanging_column(1, 0, 1.5 * weight, 0.75);
    scene.scene().grains[0].position[1] -= 0.7; // lists reach 0.3, and half of d_w from either side
    SerialRun run(scene.scene());
    run.steps(1);
    EXPECT_NEAR(run.grain(0).v[1], 0.5 * g * h, 1e-12) << "drawn up by half its weight";
}

TEST(Cohesion, ABondHoldsFrictionWithoutPressure) {
    // A disk that spins on a floor without gravity: |r_t| = mu gamma h, until it rolls at t* = r w0 m / (3 mu gamma).
    const double mu = 0.4, gamma = 1e3, rim = 1;
    SceneBuilder scene(mu);
    scene.gravity(0, 0).cohesion(0, 0, gamma, 0.01).floor();
    scene.grain(r, {0, r}, {0, 0}, rim / r);
    scene.stage(solver(h, 20));
    SerialRun run(scene.scene());
    const double rolls = rim * disk_mass(r) / (3 * mu * gamma);
    const auto half = static_cast<int>(0.5 * rolls / h);
    run.steps(half);
    // The contact point moves backwards over the floor at +x spin: friction drives the disk to -x.
    EXPECT_NEAR(run.grain(0).v[0], -mu * gamma * half * h / disk_mass(r), 1e-9);
    EXPECT_NEAR(run.rim_speed(0), rim - 2 * mu * gamma * half * h / disk_mass(r), 1e-9);
    EXPECT_NEAR(run.grain(0).x[1], r, 1e-12);
    run.steps(2 * half);
    EXPECT_NEAR(run.grain(0).v[0], -rim / 3, 1e-9);
    EXPECT_NEAR(run.rim_speed(0), rim / 3, 1e-9);
}

TEST(Cohesion, MaterialsThatDoNotAttractKeepThePlainLaw) {
    // Grain 0 hangs from a ceiling that attracts; grain 1, of another material beside it, falls freely.
    SceneBuilder scene;
    const int top = scene.material("ceiling"), other = scene.material("other");
    scene.law(0, top, 0).law(0, other, 0).law(other, other, 0).law(other, top, 0).cohesion(0, top, 2 * weight, 0.01);
    scene.wall("ceiling", {{-5, 0}, {5, 0}}, top).grain(r, {0, -r}).grain(r, {2 * r, -r}, {0, 0}, 0, other);
    scene.stage(solver(h, 50));
    SerialRun run(scene.scene());
    run.steps(200);
    EXPECT_NEAR(run.grain(0).x[1], -r, 1e-12);
    EXPECT_NEAR(run.grain(1).v[1], -g * 0.2, 1e-9);
}

/// Random batches in which each body is in one lane only.
struct RandomBatches {
    explicit RandomBatches(int n)
        : batches(static_cast<std::size_t>(n)), tangent(batches.size()), friction(batches.size()),
          cohesion(batches.size()) {
        std::mt19937_64 random(7);
        std::uniform_real_distribution<double> number(-1, 1);
        std::uint32_t body = 0;
        for (std::size_t k = 0; k < batches.size(); ++k) {
            for (int l = 0; l < n_lanes; ++l) {
                const double angle = 3 * number(random);
                auto& batch = batches[k];
                batch.nx[l] = std::cos(angle);
                batch.ny[l] = std::sin(angle);
                batch.bias[l] = l % 3 == 0 ? 0.5 * (1 + number(random)) : 0.0;
                batch.r_n[l] = l % 2 == 0 ? 1 + number(random) : 0.0;
                tangent[k].r_t[l] = 0.3 * batch.r_n[l] * number(random);
                batch.a[l] = 4 * body++;
                batch.b[l] = 4 * body++;
                friction[k].mu[l] = 0.5 * (1 + number(random));
                for (int side = 0; side < 2; ++side) {
                    u.push_back({{number(random), number(random)}, {number(random)}, 1.5 + number(random)});
                }
                batch.m_eff[l] = 1 / (u[u.size() - 1].inv_m + u[u.size() - 2].inv_m);
            }
        }
    }

    void relax(const DiskKernels& kernels, bool mixed, bool cohesive) {
        kernels.relax({batches.data(), static_cast<std::int64_t>(batches.size()), tangent.data(),
                       mixed ? friction.data() : nullptr, cohesive ? cohesion.data() : nullptr, 0.4},
                      u.data()->v.data(), {});
    }

    std::vector<DiskBatch> batches;
    std::vector<TangentBatch> tangent;
    std::vector<FrictionBatch> friction;
    std::vector<CohesionBatch> cohesion;
    std::vector<BodyVelocity<2>> u;
};

template <class T>
bool same_bytes(const std::vector<T>& one, const std::vector<T>& other) {
    return one.size() == other.size() && std::memcmp(one.data(), other.data(), one.size() * sizeof(T)) == 0;
}

TEST(Cohesion, KernelWithoutAttractionGivesThePlainLawsBits) {
    for (const char* name : {"scalar", "portable", "avx2", "avx512"}) {
        const DiskKernels* kernels = nullptr;
        try {
            kernels = &disk_kernels(name);
        } catch (const std::exception&) {
            continue; // not on this machine
        }
        for (const bool mixed : {false, true}) {
            RandomBatches plain(8), cohesive(8);
            for (int sweep = 0; sweep < 3; ++sweep) {
                plain.relax(*kernels, mixed, false);
                cohesive.relax(*kernels, mixed, true);
            }
            EXPECT_TRUE(same_bytes(plain.batches, cohesive.batches)) << name;
            EXPECT_TRUE(same_bytes(plain.tangent, cohesive.tangent)) << name;
            EXPECT_TRUE(same_bytes(plain.u, cohesive.u)) << name;
            cohesive.cohesion[3].most[2] = 0.1;
            cohesive.batches[3].bias[2] = 9; // opens: the pull shows
            cohesive.relax(*kernels, false, true);
            EXPECT_DOUBLE_EQ(cohesive.batches[3].r_n[2], -0.1) << name << ": the test looks at the right array";
        }
    }
}

TEST(Cohesion, AllInstructionSetsGiveOneHash) {
    std::map<std::uint64_t, std::string> seen;
    for (const char* name : {"scalar", "portable", "avx2", "avx512"}) {
        try {
            (void)disk_kernels(name);
        } catch (const std::exception&) {
            continue;
        }
        SceneBuilder scene(0.4);
        scene.box(6, 4, {RadiusLaw::Kind::uniform, 0.13, 0.26}).cohesion(0, 0, 1e4, 0.01).stage(solver(0.01, 30));
        scene.scene().walls[1].motion = Motion<2>{{0.3, 0.1}, 0, 0, {}};
        SerialRun run(scene.scene(), name);
        run.steps(150);
        seen.emplace(run.simulation().state_hash(), name);
        EXPECT_GT(run.simulation().counters().relaxations, 0);
    }
    EXPECT_EQ(seen.size(), 1u);
}

TEST(Cohesion, SamplesArePreparedWithoutIt) {
    const auto hash = [](double gamma) {
        SceneBuilder scene(0.4);
        scene.box(6, 4, {RadiusLaw::Kind::uniform, 0.13, 0.26}).cohesion(0, 0, gamma, 0.02).stage(solver(0.01, 30));
        scene.scene().stages[0].until = SettleCriterion{};
        SerialRun run(scene.scene());
        run.steps(100);
        return run.simulation().state_hash();
    };
    EXPECT_EQ(hash(1e5), hash(0));
}

} // namespace
} // namespace nappe::test::cohesion_test
