// Cundall's smooth contacts against formulas of oscillators (shared by all: central differences keep the frequency w' with
// sin(w' h / 2) = w h / 2, and the product below, to the bit of round-off).
#include "core/smooth_step.hpp"
#include "support/smooth_run.hpp"
#include "support/watched_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

namespace nappe::test::smooth {
namespace {

/// What central differences keep of an oscillation: w² x² + v_- v_+, x a position and v_-, v_+ the velocities half a step
/// before and after it.
double kept(double w2, double x, double before, double after) {
    return w2 * x * x + before * after;
}

TEST(Smooth, PairBouncesInTheTimeOfHalfAnOscillation) {
    // Head on without dashpots: m_eff = m/2, w = sqrt(k / m_eff), contact lasts pi / w and velocities are exchanged.
    const double w = std::sqrt(2 * k / m), h = 0.01 / w, v0 = 0.1;
    SceneBuilder b;
    b.gravity(0, 0).grain(r, {0, 0}, {v0, 0}).grain(r, {2 * r + 0.5 * h * v0, 0}).stage(smooth_settings(h));
    WorldRun run(with_springs(b));
    int touching = 0, n = 0;
    do {
        run.steps(1);
        touching += run.normal_impulse(0, 1) > 0 ? 1 : 0;
    } while (++n < 600);
    const double numeric = 2 * std::asin(0.5 * w * h) / h;
    EXPECT_NEAR(touching * h, pi / numeric, 1.01 * h) << "a contact begins and ends within a step";
    // The last force acts on for up to a step past the opening: w h / 2 of the velocity at most, squared in what is lost.
    EXPECT_NEAR(run.grain(1).v[0], v0, v0 * w * h);
    EXPECT_NEAR(run.grain(0).v[0] + run.grain(1).v[0], v0, 100 * n * ulp * v0);
}

TEST(Smooth, DashpotsGiveTheRestitutionOfADampedOscillator) {
    const double w = std::sqrt(2 * k / m), v0 = 0.1;
    for (const double zeta : {0.1, 0.4}) {
        const double wanted = std::exp(-pi * zeta / std::sqrt(1 - zeta * zeta));
        double before = 0;
        for (const double wh : {0.02, 0.01, 0.005}) {
            const double h = wh / w;
            SceneBuilder b;
            b.gravity(0, 0).grain(r, {0, 0}, {v0, 0}).grain(r, {2 * r, 0}).stage(smooth_settings(h));
            SerialRun run(with_springs(b, 0, 2 * zeta * w * m / 2));
            run.steps(static_cast<int>(8 / wh));
            EXPECT_EQ(run.normal_impulse(0, 1), 0) << "still together";
            const double e = (run.grain(1).v[0] - run.grain(0).v[0]) / v0;
            // The dashpot is half a step late, the opening up to one: of first order in w h, by about one.
            EXPECT_NEAR(e, wanted, wh) << zeta;
            before = e;
        }
        EXPECT_NEAR(before, wanted, 0.005);
    }
}

TEST(Smooth, CriticalDashpotsAreTheDefaultAndStopAPair) {
    const double w = std::sqrt(2 * k / m), h = 0.001 / w, v0 = 0.1;
    SceneBuilder b;
    b.gravity(0, 0).grain(r, {0, 0}, {v0, 0}).grain(r, {2 * r, 0}).stage(smooth_settings(h));
    for (auto& law : b.scene().laws) {
        law.springs = Springs{{k}, {0}};
    }
    WorldRun run(b.scene());
    const double t = 5 / w;
    run.steps(static_cast<int>(std::lround(t / h)));
    // x = v0 t exp(-w t), zeta = 1: the overlap never ends, and dies out.
    const double overlap = run.grain(0).x[0] + 2 * r - run.grain(1).x[0];
    EXPECT_NEAR(overlap, v0 * t * std::exp(-w * t), 0.01 * v0 * t * std::exp(-w * t));
}

TEST(Smooth, SpringsTooSoftToKeepGrainsApartAreRefusedUnlessUnsafe) {
    // Head on at a speed whose energy springs of this stiffness take up in two radii and more: m_eff v² > k (2 r)².
    const double v0 = 3 * r * std::sqrt(2 * k / m), h = 0.01 * r / v0;
    for (const bool unsafe : {false, true}) {
        SceneBuilder b;
        auto settings = smooth_settings(h);
        settings.unsafe = unsafe;
        b.gravity(0, 0).grain(r, {0, 0}, {v0, 0}).grain(r, {2 * r, 0}).stage(settings);
        WorldRun run(with_springs(b));
        if (unsafe) {
            run.steps(600);
            EXPECT_GT(run.grain(0).x[0], run.grain(1).x[0]) << "it has gone through";
            EXPECT_GT(run.simulation().watcher().memory().steps[static_cast<std::size_t>(Watched::overlap)], 0);
        } else {
            EXPECT_THROW(run.steps(600), NumericalFailure);
        }
    }
}

TEST(Smooth, TheTangentialDashpotGoesByTheNormalStiffnessUnlessGiven) {
    // seeds/004: c_S = c_N = 2 sqrt(m k_N). Without a tangential spring it is all that brakes the rim, of a disk pressed
    // down by its weight, from one step to the next: m dv = -h c_S v.
    const double w = std::sqrt(k / m), h = 0.01 / w, v0 = 1e-3;
    SceneBuilder b(1000);
    b.floor().grain(r, {0, r - m * g / k}, {v0, 0}).stage(smooth_settings(h));
    for (auto& law : b.scene().laws) {
        law.springs = Springs{{k}, {0}};
    }
    WorldRun run(b.scene());
    run.steps(1);
    EXPECT_NEAR((v0 - run.grain(0).v[0]) / v0, h * 2 * w, 1e-9);
}

/// A disk on a floor, pressed by its weight; `lift` over where it would rest, in shares of the overlap m g / k.
Scene<2> resting(double h, double lift) {
    SceneBuilder b;
    b.floor().grain(r, {0, r - (1 - lift) * m * g / k}).stage(smooth_settings(h));
    return with_springs(b);
}

TEST(Smooth, AnOscillatorKeepsItsEnergyAndPeriodForAThousandPeriods) {
    const double w = std::sqrt(k / m), h = 0.2 / w, at_rest = r - m * g / k;
    SerialRun run(resting(h, 0.5));
    double x = run.grain(0).x[1] - at_rest, v = run.grain(0).v[1];
    double first = 0, t_first = 0, t_last = 0;
    int periods = 0;
    for (int n = 1; periods < 1000; ++n) {
        run.steps(1);
        const double after = run.grain(0).v[1], next = run.grain(0).x[1] - at_rest;
        const double now = kept(w * w, x, v, after);
        if (n == 1) {
            first = now;
        }
        // x is a small difference of r and r - m g / k: an ulp of r is so much of the oscillation.
        ASSERT_NEAR(now / first, 1, 1e-9) << n;
        if (x < 0 && next >= 0) {
            const double t = h * (n - 1 + x / (x - next)); // straight between two steps: w h of a period off at most
            periods += t_first > 0 ? 1 : 0;
            t_first = t_first > 0 ? t_first : t;
            t_last = t;
        }
        x = next;
        v = after;
    }
    const double numeric = 2 * std::asin(0.5 * w * h) / h;
    EXPECT_NEAR((t_last - t_first) / periods, 2 * pi / numeric, 1e-3 * h);
}

TEST(Smooth, StableBelowTheCriticalStepAndNotAbove) {
    const double critical = 2 * std::sqrt(m / k), overlap = m * g / k;
    const auto farthest = [&](double share, int n) {
        WorldRun run(resting(share * critical, 1e-6));
        double most = 0;
        for (int i = 0; i < n; ++i) {
            run.steps(1);
            most = std::max(most, std::abs(run.grain(0).x[1] - (r - overlap)));
        }
        return most / (1e-6 * overlap);
    };
    // From the product kept: x² (1 - (w h / 2)²) <= x0² + (v0 / w)², v0 = h w² x0 / 2 to either side: a factor of 11 at most.
    EXPECT_LT(farthest(0.995, 5000), 20);
    // Above: grows as (s + sqrt(s² - 1))^2 a step, s = share: 1.22, e^30 in 150 steps.
    EXPECT_GT(farthest(1.005, 300), 1e6);
}

/// Disks on a square lattice in a box that presses all of them together by `overlap`, each with a velocity that no other has.
Scene<2> lattice(double overlap, double share, std::optional<double> c) {
    constexpr int n = 5;
    const double apart = 2 * r - overlap, first = r - overlap, side = 2 * first + (n - 1) * apart;
    SceneBuilder b(1e3); // all that touches sticks
    b.gravity(0, 0);
    b.wall("box", {{0, side}, {0, 0}, {side, 0}, {side, side}, {0, side}});
    for (int i = 0; i < n * n; ++i) {
        const Vec<2> v(std::sin(12.9898 * i), std::sin(78.233 * i));
        b.grain(r, {first + i % n * apart, first + i / n * apart}, 1e-6 * v, 1e-6 * std::sin(37.719 * i));
    }
    auto scene = b.scene();
    for (auto& law : scene.laws) {
        law.springs = Springs{{k, c}, {k, c}};
    }
    scene.stages.push_back({"shake", {}, 0, smooth_settings(share * smooth_bounds(scene).stable)});
    return scene;
}

TEST(Smooth, NoOscillationOfAPackingGrowsUpToTheStepThatIsAsked) {
    // Without dashpots energy stays what it was, as (w h / 2)² allows; with them it goes. Somewhere above, at least
    // sqrt(36/16) times, it grows: all disks that spin alike have 16 k/m, where 3 k (6/m + 6/m) is reckoned with.
    for (const auto c : {std::optional<double>(0), std::optional<double>()}) {
        for (const double share : {0.99, 2.5}) {
            SerialRun run(lattice(0.01, share, c));
            double first = 0, most = 0;
            for (int n = 0; n < 2000 && most < 1e3 * first + (n < 2 ? 1 : 0); ++n) {
                double energy = 0;
                for (const auto& row : run.grains()) {
                    const double rim = row.radius * row.spin[0];
                    energy += 0.5 * m * (row.v[0] * row.v[0] + row.v[1] * row.v[1] + 0.5 * rim * rim);
                }
                first = n == 0 ? energy : first;
                most = std::max(most, energy);
                run.steps(1);
            }
            if (share < 1) {
                EXPECT_LT(most, 100 * first) << "(1 - 0.99²) of the energy may be seen as kinetic one half a step off";
            } else {
                EXPECT_GT(most, 1e3 * first) << "the step asked for is far too short";
            }
        }
    }
}

TEST(Smooth, GlobalDampingHasATerminalVelocityAndSlowsSpinByItsFactor) {
    const double h = 1e-3, c = 0.5 * m, inertia = 0.5 * m * r * r, c_spin = 0.7 * inertia;
    SceneBuilder b(0.1);
    b.grain(r, {0, 0}, {0.3, 0}, 5).stage(smooth_settings(h));
    b.scene().materials[0].damping = c;
    b.scene().materials[0].spin_damping = c_spin;
    SerialRun run(with_springs(b));
    const double a = 0.5 * h * c / m, a_spin = 0.5 * h * c_spin / inertia;
    double vx = 0.3, vy = 0, spin = 5;
    for (int n = 0; n < 1000; ++n) {
        vx *= (1 - a) / (1 + a);
        vy = (vy * (1 - a) - h * g) / (1 + a);
        spin *= (1 - a_spin) / (1 + a_spin);
    }
    run.steps(1000);
    EXPECT_NEAR(run.grain(0).v[0], vx, 1000 * ulp);
    EXPECT_NEAR(run.grain(0).v[1], vy, 1000 * 20 * ulp);
    EXPECT_NEAR(run.grain(0).spin[0], spin, 1000 * 5 * ulp);
    run.steps(79000);
    EXPECT_NEAR(run.grain(0).v[1], -m * g / c, 1e-10); // exp(-c t / m) = e^-40 of it is left
}

TEST(Smooth, FrictionSlidesAtItsLimit) {
    // On the floor at rest, thrown along it: friction is mu m g until it rolls, (2/3) of v0 later.
    const double mu = 0.3, v0 = 5, w = std::sqrt(k / m), h = 0.02 / w;
    SceneBuilder b(mu);
    b.floor(1000).grain(r, {0, r - m * g / k}, {v0, 0}).stage(smooth_settings(h));
    WorldRun run(with_springs(b, k, 0, 2 * std::sqrt(m * k)));
    const int n = 200;
    run.steps(n);
    // In the first step the dashpot alone is at the limit already.
    EXPECT_NEAR(run.grain(0).v[0], v0 - mu * g * n * h, 1e-7 * mu * g * n * h);
    EXPECT_NEAR(run.rim_speed(0), -2 * mu * g * n * h, 2e-7 * mu * g * n * h);
    run.steps(static_cast<int>(v0 / (3 * mu * g) / h * 1.5));
    EXPECT_NEAR(run.grain(0).v[0], 2 * v0 / 3, 1e-3 * v0);
    EXPECT_NEAR(run.rim_speed(0), -run.grain(0).v[0], 1e-3 * v0);
}

TEST(Smooth, AFloorInPiecesCarriesAsOne) {
    // Slides over joints, where the contact with one piece ends and that with the next one begins, both as deep.
    const double w = std::sqrt(k / m), h = 0.02 / w, y = r - m * g / k;
    SceneBuilder b;
    b.wall("floor", {{-100, 0}, {0.1, 0}, {0.4, 0}, {0.7, 0}, {100, 0}})
        .grain(r, {0, y}, {2, 0})
        .stage(smooth_settings(h));
    WorldRun run(with_springs(b));
    while (run.grain(0).x[0] < 1) {
        run.steps(1);
        // A step without support: g h², 4e-6 of r.
        ASSERT_NEAR(run.grain(0).x[1], y, 1e-12 * r) << "at " << run.grain(0).x[0];
    }
}

TEST(Smooth, TheTangentialSpringCarriesADiskThatSticks) {
    // The floor starts with V: slip oscillates with w_t = sqrt(3 k_s / m), since a force at the rim moves it by 3 F / m. The
    // spring is stretched most after a quarter of a period, by V / w_t.
    const double k_s = 1e5, w_t = std::sqrt(3 * k_s / m), h = 0.01 / w_t, speed = 0.01;
    SceneBuilder b(10);
    Motion<2> along;
    along.stage = 0;
    along.velocity = {speed, 0};
    b.moving_wall("floor", {{-100, 0}, {100, 0}}, along);
    b.grain(r, {0, r - m * g / k}).stage(smooth_settings(h));
    WorldRun run(with_springs(b, k_s));
    double most = 0, t_most = 0;
    for (int n = 1; n * w_t * h < 4; ++n) {
        run.steps(1);
        for (const auto& contact : run.loaded_contacts()) {
            const double force = std::abs(contact.r_t[0]) / h;
            t_most = force > most ? n * h : t_most;
            most = std::max(most, force);
        }
    }
    // Velocities are half a step old: w h / 2 = 0.5 %.
    EXPECT_NEAR(most, k_s * speed / w_t, 0.005 * k_s * speed / w_t);
    EXPECT_NEAR(t_most * w_t, pi / 2, 0.02);
}

/// Grains that fall on each other between walls, tiles as small as they may be.
Scene<2> heap() {
    SceneBuilder b(0.3);
    b.box(12, 6, {RadiusLaw::Kind::uniform, 0.15, 0.25}, 5).grain(0.25, {6, 8}, {0.5, -6}, 20);
    b.stage(smooth_settings(2e-4));
    for (auto& law : b.scene().laws) {
        law.springs = Springs{{2e6, 400}, {1e6, 200}};
    }
    b.scene().materials[0].damping = 30;
    auto scene = b.scene();
    scene.tiles.side = 1.5;
    return scene;
}

TEST(Smooth, TheSameOnAnyNumberOfRanksAndInstructionSets) {
    const Communicator world;
    WatchedRun together(world, heap());
    ASSERT_EQ(together.steps(400), "");
    const auto hash = together.simulation().state_hash();
    EXPECT_GT(together.simulation().counters().rebuilds, 2);
    for (const std::string kernel : {"scalar", "portable", "avx2", "avx512"}) {
        try {
            SerialRun alone(heap(), kernel.c_str());
            alone.steps(400);
            EXPECT_EQ(alone.simulation().state_hash(), hash) << kernel;
        } catch (const InputError&) {
            EXPECT_TRUE(kernel.starts_with("avx")) << "only these may be missing";
        }
    }
}

} // namespace
} // namespace nappe::test::smooth
