// Bodies at rest: a column that must carry itself for ever, and a disk wedged between two planes.

#include "support/serial_run.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace nappe::test::statics_test {
namespace {

constexpr double g = standard_gravity;

/// n equal disks on top of each other: contact k (0 is the floor's) carries the n - k disks above it. Sweeps diffuse forces along the
/// column, n² of them a decade or so: the first step gets enough for round-off. From there on impulses are warm, every
/// velocity is zero to round-off, and nothing may creep in 10,000 steps of ordinary effort.
TEST(Statics, ColumnCarriesItselfAndDoesNotDrift) {
    const int n = 12;
    const double r = 0.37, h = 5e-3;
    SceneBuilder b(0.4);
    b.floor();
    for (int k = 0; k < n; ++k) {
        b.grain(r, {0.3, r * (2 * k + 1)});
    }
    b.stage(solver(h, 6000)).stage(solver(h, 20));
    SerialRun run(b.scene());
    run.steps(1);
    std::vector<GrainRow<2>> start;
    for (int k = 0; k < n; ++k) {
        start.push_back(run.grain(k));
    }
    run.simulation().start_stage(1);
    run.steps(10'000);
    const double weight = disk_mass(r) * g * h;
    for (int k = 0; k < n; ++k) {
        const double carried = k == 0 ? run.normal_impulse(0, wall_id(0)) : run.normal_impulse(k - 1, k);
        // Round-off of the cold solve, over the slowest mode's share of a sweep (1/n² of the error).
        EXPECT_NEAR(carried, (n - k) * weight, 1e-10 * n * weight) << "contact " << k;
        // Velocities of round-off size (1e-15 m/s for g h = 0.05) over 50 s.
        EXPECT_NEAR(run.grain(k).x[0], start[static_cast<std::size_t>(k)].x[0], 1e-12) << "disk " << k;
        EXPECT_NEAR(run.grain(k).x[1], start[static_cast<std::size_t>(k)].x[1], 1e-12) << "disk " << k;
        EXPECT_NEAR(run.grain(k).x[1], r * (2 * k + 1), 1e-12) << "disk " << k;
    }
}

/// Two planes that rise from the origin, at a_1 to the left and a_2 to the right, and a disk that touches both.
SerialRun wedged(double a_1, double a_2, double r, double h, double mu) {
    SceneBuilder b(mu);
    b.wall("left", {{-10 * std::cos(a_1), 10 * std::sin(a_1)}, {0, 0}});
    b.wall("right", {{0, 0}, {10 * std::cos(a_2), 10 * std::sin(a_2)}});
    // Centre c with c·n_1 = c·n_2 = r, n_1 = (sin a_1, cos a_1), n_2 = (-sin a_2, cos a_2).
    const double det = std::sin(a_1 + a_2);
    b.grain(r, {r * (std::cos(a_2) - std::cos(a_1)) / det, r * (std::sin(a_1) + std::sin(a_2)) / det});
    b.stage(solver(h, 500));
    return SerialRun(b.scene());
}

/// Without friction: N_1 n_1 + N_2 n_2 = (0, m g) gives N_1 = m g sin a_2 / sin(a_1 + a_2) and N_2 likewise.
TEST(Statics, WedgedDiskWithoutFriction) {
    const double r = 0.5, h = 1e-2;
    const double angles[][2] = {{0.3, 0.3}, {0.2, 0.9}, {1.1, 0.5}, {1.2, 1.2}};
    for (const auto& [a_1, a_2] : angles) {
        auto run = wedged(a_1, a_2, r, h, 0);
        run.steps(20);
        const double weight = disk_mass(r) * g * h;
        // Two contacts: a sweep reduces the error by cos²(a_1 + a_2) <= 0.7, so 500 of them reach round-off.
        EXPECT_NEAR(run.normal_impulse(0, wall_id(0)), weight * std::sin(a_2) / std::sin(a_1 + a_2), 1e-12 * weight);
        EXPECT_NEAR(run.normal_impulse(0, wall_id(1)), weight * std::sin(a_1) / std::sin(a_1 + a_2), 1e-12 * weight);
        EXPECT_NEAR(run.grain(0).v[0], 0, 1e-12);
        EXPECT_NEAR(run.grain(0).v[1], 0, 1e-12);
    }
}

/// With friction four unknowns meet three equations: only balance and Coulomb's bound can be asked.
TEST(Statics, WedgedDiskWithFriction) {
    const double r = 0.5, h = 1e-2, mu = 0.4;
    const double angles[][2] = {{0.3, 0.3}, {0.2, 0.9}, {1.1, 0.5}, {1.2, 1.2}};
    for (const auto& [a_1, a_2] : angles) {
        auto run = wedged(a_1, a_2, r, h, mu);
        run.steps(20);
        const double weight = disk_mass(r) * g * h;
        Vec<2> force(0, -weight);
        double moment = 0;
        const auto contacts = run.loaded_contacts();
        ASSERT_EQ(contacts.size(), 2u);
        for (const auto& c : contacts) {
            force += c.r_n * Vec<2>(c.normal[0], c.normal[1]) + c.r_t[0] * Vec<2>(-c.normal[1], c.normal[0]);
            moment += c.r_t[0];
            EXPECT_LE(std::abs(c.r_t[0]), mu * c.r_n * (1 + 1e-15));
        }
        EXPECT_LE(force.norm(), 1e-12 * weight) << a_1 << " " << a_2;
        EXPECT_LE(std::abs(moment), 1e-12 * weight) << a_1 << " " << a_2;
        EXPECT_NEAR(run.grain(0).v[1], 0, 1e-12);
        EXPECT_NEAR(run.rim_speed(0), 0, 1e-12);
    }
}

} // namespace
} // namespace nappe::test::statics_test
