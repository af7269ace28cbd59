// What too few sweeps do (Unger & Kertész 2003, Int. J. Mod. Phys. B 17, 5623): N sweeps from zero impulses let forces diffuse
// sqrt(q N) grains far. Derived here for a column of equal disks (mass m, diameter d), contacts k = 0 (floor), 1, …, one step of h:
//
// A relaxation sets a contact's impulse R_k to what stops its approach. In the interior W = 2/m, and the error e of R obeys, per
// sweep, Jacobi: e_k <- (e_k-1 + e_k+1)/2, whose wave of wave number x has the factor cos x: diffusion with q = 1/2 (per sweep, in
// d²). Our order relaxes a chain in two classes, even contacts and odd ones, each with the other's new values: the factor is
// cos² x, q = 1. (Random order: 0.797.) Tiles keep nearly that: inside a tile classes are as above, and borders are few.
//
// Of their damped elastic bar only the damper is left here: it is their gap term that is elastic, and this law does not push out
// overlaps (max(g, 0)/h), so the wave speed sqrt(q N) d / h has nothing to show itself in. The viscosity q N m / h does.

#include "support/serial_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace nappe::test::cold_start_test {
namespace {

constexpr double g = standard_gravity;
constexpr double r = 0.5;

Scene<2> column(int n, double h, int sweeps, double tile_side) {
    SceneBuilder b;
    b.floor();
    for (int k = 0; k < n; ++k) {
        b.grain(r, {0, r * (2 * k + 1)});
    }
    b.stage(solver(h, sweeps));
    b.scene().tiles.side = tile_side;
    return b.scene();
}

/// The falling column meets the floor: R diffuses from there with the flux m g h / d. A half-space under constant flux has, after N
/// sweeps, R_floor = m g h 2 sqrt(q N / pi): the weight of that many disks, and no more, is carried, as long as sqrt(q N) << n.
/// With whole contacts instead of a continuum it is 2 N binomial(2N, N) / 4^N disks for q = 1, so that q looks like 1 - 1/(4 N).
double q_of_the_first_step(int n, int sweeps, double tile_side) {
    const double h = 1e-3;
    SerialRun run(column(n, h, sweeps, tile_side));
    run.steps(1);
    const double carried = run.normal_impulse(0, wall_id(0)) / (disk_mass(r) * g * h);
    return std::numbers::pi * carried * carried / (4 * sweeps);
}

TEST(ColdStart, FloorCarriesTheWeightThatSweepsHaveReached) {
    const int n = 200;
    for (const double tile_side : {8.0, 210.0}) { // 8 disks a tile, or one tile for all
        for (const int sweeps : {16, 64, 256, 1024}) {
            // 1/N for the next term of the series; 1e-3 for tile borders and the far end, of which the sweeps know nothing yet.
            EXPECT_NEAR(q_of_the_first_step(n, sweeps, tile_side), 1 - 0.25 / sweeps, 0.1 / sweeps + 1e-3)
                << "tile " << tile_side << " sweeps " << sweeps;
        }
    }
}

/// Cold in every step, the column creeps: contact k must carry the n - k disks above it, R_k = (n - k) m g h, but N sweeps give only
/// R = q N m U for an approach U: U_k = (n - k) g h / (q N). So it sinks for ever, the faster the fewer the sweeps. The class that is
/// relaxed last ends each step at rest and the other approaches at 2 U: sums that start with either are averaged.
TEST(ColdStart, ColumnCreepsAsADamper) {
    const int n = 40;
    const double h = 1e-3;
    for (const int sweeps : {4, 8, 16}) {
        SerialRun run(column(n, h, sweeps, 2 * n * r + 10)); // all in one tile
        const int settled = 3 * n * n / sweeps; // the slowest mode decays by q N (pi/2 / n)² a step: e^-7 is left
        for (int k = 0; k < settled; ++k) {
            run.forget_impulses();
            run.steps(1);
        }
        double approach = 0, expected = 0;
        const int near_floor = 3 * static_cast<int>(std::sqrt(sweeps)); // so many contacts feel it
        for (const int first : {near_floor, near_floor + 1}) {
            approach += run.grain(first - 1).v[1] - run.grain(n - 1).v[1];
            for (int k = first; k < n; ++k) {
                expected += (n - k) * g * h / sweeps;
            }
        }
        // The averaging leaves 1/n² of the sum, the modes and the floor's reach 1e-3 each or so.
        EXPECT_NEAR(expected / approach, 1.0, 0.01) << "sweeps " << sweeps;
    }
}

} // namespace
} // namespace nappe::test::cold_start_test
