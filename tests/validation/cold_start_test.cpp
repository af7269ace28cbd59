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

namespace nappe::test {
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
double q_of_the_first_step(int n, int sweeps, double tile_side) {
    const double h = 1e-3;
    SerialRun run(column(n, h, sweeps, tile_side));
    run.steps(1);
    const double carried = run.normal_impulse(0, wall_id(0)) / (disk_mass(r) * g * h);
    return std::numbers::pi * carried * carried / (4 * sweeps);
}

TEST(ColdStart, FloorCarriesTheWeightThatSweepsHaveReached) {
    const int n = 200;
    for (const double tile_side : {8.0, 1000.0}) { // 8 disks a tile, or one tile for all
        for (const int sweeps : {16, 64, 256, 1024}) {
            const double q = q_of_the_first_step(n, sweeps, tile_side);
            std::printf("tile %g m, %d sweeps: q = %.4f\n", tile_side, sweeps, q);
            // q = 1, and of order 1/sqrt(N) of a discrete start (half a contact's width of sqrt(N)).
            EXPECT_NEAR(q, 1.0, 0.02 + 1 / std::sqrt(sweeps)) << "tile " << tile_side << " sweeps " << sweeps;
        }
    }
}

/// Cold in every step, the column creeps: contact k must carry the n - k disks above it, R_k = (n - k) m g h, but N sweeps give only
/// R = q N m U for an approach U: U_k = (n - k) g h / (q N). So it sinks for ever, the faster the fewer the sweeps.
TEST(ColdStart, ColumnCreepsAsADamper) {
    const int n = 40;
    const double h = 1e-3;
    for (const int sweeps : {4, 8, 16}) {
        SerialRun run(column(n, h, sweeps, 0));
        const int settled = 3 * n * n / sweeps; // the slowest mode decays by q N (pi/2 / n)² a step: e^-7 is left
        for (int k = 0; k < settled; ++k) {
            run.forget_impulses();
            run.steps(1);
        }
        // Free approach velocities of the next step are those at the end of this one, gravity being common. Fit U over n - k, above
        // the few sqrt(N) contacts that feel the floor.
        double xy = 0, xx = 0;
        const int first = 3 * static_cast<int>(std::sqrt(sweeps));
        for (int k = first; k < n; ++k) {
            const double approach = run.grain(k - 1).v[1] - run.grain(k).v[1];
            xy += approach * (n - k);
            xx += (n - k) * (n - k);
        }
        const double q = g * h / (xy / xx) / sweeps;
        std::printf("%d sweeps: creeps as q = %.4f\n", sweeps, q);
        EXPECT_NEAR(q, 1.0, 0.15) << "sweeps " << sweeps;
    }
}

} // namespace
} // namespace nappe::test
