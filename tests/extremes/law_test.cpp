// Friction from 0 to 10, restitution from 0 to 1, cohesion from 0 to 1e8 N.

#include "extremes/findings.hpp"

#include <gtest/gtest.h>

namespace nappe::test {
namespace {

constexpr double g = standard_gravity;

/// A disk on a slope at angle a: it rolls with (2/3) g sin a while tan a <= 3 mu, else it slides with g (sin a - mu cos a).
TEST(Friction, SlopesOfEveryAngle) {
    const double r = 0.5, h = 1e-3;
    for (const double mu : {0.0, 0.1, 0.4, 1.0, 3.0, 10.0}) {
        for (const double angle : {1e-3, 0.3, 0.8, 1.2, 1.5, 1.56}) {
            SceneBuilder b(mu);
            b.gravity(g * std::sin(angle), -g * std::cos(angle)).floor(1000).grain(r, {0, r});
            b.stage(solver(h, 50));
            SerialRun run(b.scene());
            run.steps(500);
            const bool rolls = std::tan(angle) <= 3 * mu;
            const double a = rolls ? 2.0 / 3 * g * std::sin(angle) : g * (std::sin(angle) - mu * std::cos(angle));
            EXPECT_NEAR(run.grain(0).v[0], a * 500 * h, 1e-9 * g) << "mu " << mu << ", angle " << angle;
            EXPECT_NEAR(run.grain(0).x[1], r, 1e-9) << "mu " << mu << ", angle " << angle;
        }
    }
}

/// Disks that fly about in a closed box without gravity, closely enough to meet several at a time.
SceneBuilder shaken_box(double mu, double e) {
    SceneBuilder b(mu, e);
    b.gravity(0, 0).wall("box", {{0, 0}, {8, 0}, {8, 8}, {0, 8}, {0, 0}});
    for (int k = 0; k < 36; ++k) {
        const double vx = std::cos(1.7 * k), vy = std::sin(2.3 * k); // any: of the order of 1 m/s
        b.grain(0.5 - 0.003 * (k % 7), {1.05 + 1.18 * (k % 6), 1.05 + 1.18 * (k / 6)}, {vx, vy}, 2 * vy);
    }
    return b;
}

/// No work is done on the box: kinetic energy may only fall, and for e = 1 without friction it stays. (An impulse r does
/// the work r (v + v')/2 of the velocities before and after. With v' = -e v, v < 0, that is negative, and so is friction's.)
TEST(Friction, EnergyOfAClosedBox) {
    for (const double mu : {0.0, 0.4, 10.0}) {
        for (const double e : {0.0, 0.5, 0.9, 1.0}) {
            auto b = shaken_box(mu, e);
            b.stage(solver(2e-3, 100));
            SerialRun run(b.scene());
            const double start = kinetic(run);
            double before = start, largest = start, largest_gain = 0;
            const auto said = run_or_refusal(run, long_form() ? 20'000 : 2000, [&] {
                const double now = kinetic(run);
                largest_gain = std::max(largest_gain, (now - before) / start);
                largest = std::max(largest, now);
                before = now;
            });
            found("box", mu, e, digits(before / start), digits(largest / start), digits(largest_gain), said);
            EXPECT_EQ(said, "");
            EXPECT_TRUE(all_finite(run));
            // Round-off, and what 100 sweeps leave unsolved of the stiffest: found 1e-12 for mu = 10 in 20,000 steps.
            EXPECT_LE(largest_gain, 1e-10) << "mu " << mu << ", e " << e;
            if (mu == 0 && e == 1) {
                EXPECT_NEAR(before / start, 1, 1e-9);
            }
        }
    }
}

/// A disk hangs from a ceiling by cohesion alone: it stays while gamma carries its weight, to one part in a thousand, and
/// falls freely where it does not, whatever the scale.
TEST(Cohesion, HoldsUpToGamma) {
    const double r = 0.5, h = 1e-3;
    for (const double gamma : decades(1e-6, 1e8)) {
        for (const double share : {0.999, 1.001}) {
            SceneBuilder b(0.4);
            b.scene().materials[0].density = share * gamma / (g * std::numbers::pi * r * r);
            b.wall("ceiling", {{-10, 0}, {10, 0}}).grain(r, {0, -r}).cohesion(0, 0, gamma, 0.01);
            b.stage(solver(h, 50));
            SerialRun run(b.scene());
            run.steps(500);
            // Beyond gamma the excess pulls over d_w = 0.01 m; a thousandth of g over half a second is 1.2 mm.
            const double fallen = -r - run.grain(0).x[1];
            const double excess = 0.5 * (1 - 1 / 1.001) * g * std::pow(500 * h, 2);
            EXPECT_NEAR(fallen, share < 1 ? 0.0 : excess, 1e-3 * excess) << "gamma " << gamma << ", " << share;
        }
    }
}

/// What the bonds of a run hold: gamma over what is left of d_w, the work that parting them would take [J].
double bond_energy(SerialRun& run, double gamma, double d_w) {
    double sum = 0;
    for (const auto& c : frame_contacts(run.simulation())) {
        const double gap = c.gap > 0 ? c.gap : 0.0;
        sum += gap <= d_w ? gamma * (d_w - gap) : 0.0;
    }
    return sum;
}

/// Seven disks, one in the middle, stick together and fall on a corner that they stick to as well: the more they stick,
/// the more impulses go round in circles. Nothing becomes infinite or runs away: kinetic and potential energy less what
/// bonds have given never grows.
TEST(Cohesion, ClusterFalls) {
    constexpr double r = 0.5, d_w = 0.05, h = 2e-3;
    for (const double gamma : decades(1, 1e8)) {
        SceneBuilder b(0.4);
        b.wall("floor", {{-10, 0}, {0, 0}, {10, 1}});
        b.grain(r, {0.1, 4});
        for (int k = 0; k < 6; ++k) {
            const double angle = (k + 0.25) * std::numbers::pi / 3;
            b.grain(r, {0.1 + 2 * r * std::cos(angle), 4 + 2 * r * std::sin(angle)});
        }
        b.cohesion(0, 0, gamma, d_w);
        b.stage(solver(h, 100));
        SerialRun run(b.scene());
        const double start = potential(run) - bond_energy(run, gamma, d_w);
        double most = start, overlap = 0;
        const auto said = run_or_refusal(run, 1000, [&] {
            most = std::max(most, kinetic(run) + potential(run) - bond_energy(run, gamma, d_w));
            overlap = std::max(overlap, overlaps(run.simulation()).largest);
        });
        double spread = 0;
        for (int k = 1; k < 7; ++k) {
            const auto p = run.grain(0).x, q = run.grain(k).x;
            spread = std::max(spread, std::hypot(p[0] - q[0], p[1] - q[1]) / (2 * r));
        }
        found("cohesion", digits(gamma), digits(overlap), digits(spread), digits((most - start) / (gamma * d_w)), said);
        EXPECT_EQ(said, "") << gamma;
        EXPECT_TRUE(all_finite(run)) << gamma;
        EXPECT_LE(most - start, 1e-9 * (std::abs(start) + gamma * d_w)) << gamma;
        EXPECT_LE(overlap, 0.01) << gamma;
        EXPECT_EQ(spread<1 + d_w, gamma> 5e5) << gamma << ": seven disks weigh 1.5e5 N and fall 3 m";
    }
}

} // namespace
} // namespace nappe::test
