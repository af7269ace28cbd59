// A pile of a few hundred disks: what is exact at every step, and what holds once it rests.

#include "support/serial_run.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace nappe::test::pile_test {
namespace {

constexpr double g = standard_gravity;

struct Balance {
    double kinetic = 0;               ///< gained [J]
    double supplied = 0;              ///< by gravity, contacts and walls [J]
    double turnover = 0;              ///< sum of the magnitudes of all terms: what round-off is relative to [J]
    double friction = 0;              ///< part of `supplied` [J]
    Vec<2> momentum = Vec<2>::Zero(); ///< gained, less that from gravity and walls [N s]
    double impulses = 0;              ///< sum of magnitudes [N s]
};

/// Energy and momentum of the last step, exact for theta = 1/2 whether the solver has converged or not: u = u_old + h g + M^-1 sum r,
/// and the kinetic energy that a grain gains is the momentum it gains times its mean velocity (old and new), so that in all
/// dKE = h m g·v̄ + sum over contacts of r·ū_rel + sum over wall contacts of r·v̄_wall.
Balance balance_of(SerialRun& run, double h) {
    auto& simulation = run.simulation();
    const auto& state = run.state();
    const auto& gravity = simulation.scene().gravity;
    Balance sum;
    const auto add = [&](double term) {
        sum.supplied += term;
        sum.turnover += std::abs(term);
    };
    for (LocalId i = 0; i < state.n_own; ++i) {
        const auto &u = state.u[i], &old = state.u_old[i];
        const double m = state.mass[i];
        sum.kinetic += kinetic_energy(u, m) - kinetic_energy(old, m);
        sum.turnover += kinetic_energy(u, m) + kinetic_energy(old, m);
        for (int d = 0; d < 2; ++d) {
            add(h * m * gravity[d] * 0.5 * (u.v[d] + old.v[d]));
            sum.momentum[d] += m * (u.v[d] - old.v[d]) - h * m * gravity[d];
        }
    }
    const auto& contacts = simulation.contacts();
    for (std::size_t t = 0; t < contacts.n_tiles(); ++t) {
        contacts.for_each(t, [&](LocalId a, LocalId b, const Vec<2>& n, double r_n, double r_t) {
            const Vec<2> along(-n[1], n[0]);
            const auto mean = [&](LocalId i) {
                return Vec<2>(0.5 * (state.u[i].v[0] + state.u_old[i].v[0]),
                              0.5 * (state.u[i].v[1] + state.u_old[i].v[1]));
            };
            const auto rim = [&](LocalId i) { return 0.5 * (state.u[i].s[0] + state.u_old[i].s[0]); };
            const Vec<2> apart = mean(a) - mean(b);
            add(r_n * n.dot(apart));
            const double slip = r_t * (along.dot(apart) - rim(a) - rim(b));
            add(slip);
            sum.friction += slip;
            const Vec<2> r = r_n * n + r_t * along;
            if (b >= state.n_held()) {
                add(r.dot(mean(b)));
                sum.momentum -= r;
            }
            sum.impulses += std::abs(r_n) + std::abs(r_t);
        });
    }
    return sum;
}

/// A pile that falls together while its left wall drives it: everything works at once, and the solver is far from converged.
Scene<2> driven_pile(double h, int sweeps) {
    SceneBuilder b(0.4);
    b.box(8, 5, {RadiusLaw::Kind::uniform, 0.3, 0.4}, 2).stage(solver(h, sweeps));
    Motion<2> motion;
    motion.velocity = {0.5, 0.0};
    b.scene().walls[1].motion = motion;
    return b.scene();
}

TEST(Pile, EnergyAndMomentumOfEveryStepCloseToRoundOff) {
    const double h = 5e-3;
    for (const int sweeps : {3, 50}) {
        SerialRun run(driven_pile(h, sweeps));
        auto& sums = run.simulation().sums();
        double friction = 0;
        for (int n = 0; n < 100; ++n) {
            sums.clear();
            run.steps(1);
            const auto sum = balance_of(run, h);
            // About a hundred disks and contacts, each changed once per sweep and class: a few hundred roundings of the turnover.
            ASSERT_NEAR(sum.kinetic, sum.supplied, 1e-13 * sum.turnover) << "sweeps " << sweeps << " step " << n;
            ASSERT_LE(sum.momentum.norm(), 1e-13 * sum.impulses) << "sweeps " << sweeps << " step " << n;
            ASSERT_GT(sum.turnover, 0);
            friction += sum.friction;
            // What the series report of walls: their work, and the impulses on them against those on the grains.
            if (n > 0) { // in the first step the wall's mean velocity is half of what it has from then on
                double work = 0;
                for (std::size_t w = 0; w < 3; ++w) {
                    work -= sums.wall_impulse(w).dot(run.simulation().walls().v[w]);
                }
                EXPECT_NEAR(sums.wall_work(), work, 1e-12 * sum.turnover);
            }
        }
        EXPECT_LT(friction, 0) << "friction takes energy";
    }
}

/// In a box with smooth walls and floor the whole weight comes down on the floor, and what one side wall takes the other gives back.
TEST(Pile, AtRestTheFloorCarriesTheWeightAndWallsBalance) {
    const double h = 5e-3;
    SceneBuilder b(0.4);
    const int smooth = b.material("smooth");
    b.law(0, smooth, 0);
    b.box(16, 6, {RadiusLaw::Kind::uniform, 0.3, 0.4}, 4, smooth).stage(solver(h, 100));
    auto converged = solver(h, 100);
    converged.tolerance = 1e-9;
    converged.max_sweeps = 200'000;
    converged.check_every = 100;
    b.stage(converged);
    SerialRun run(b.scene());
    auto& simulation = run.simulation();
    ASSERT_GT(simulation.state().n_own, 180);
    const double weight = simulation.total_mass() * g;
    const double scale = weight * simulation.mean_radius();
    int steps = 0;
    do {
        run.steps(50, true);
        steps += 50;
        ASSERT_LT(steps, 4000) << "did not come to rest";
    } while (energies(simulation).kinetic > 1e-11 * scale);
    simulation.start_stage(1);
    run.steps(5);
    simulation.sums().clear();
    run.steps(1);
    EXPECT_EQ(simulation.counters().unconverged, 0);
    const auto on = [&](std::size_t wall) -> Vec<2> { return simulation.sums().wall_impulse(wall) / h; };
    // A residual of 1e-9 leaves velocities of 1e-9 g h: forces are right to 1e-9 times the height of the pile squared, in grains.
    EXPECT_NEAR(on(0)[1], -weight, 1e-5 * weight);
    EXPECT_NEAR(on(1)[0], -on(2)[0], 1e-5 * weight);
    EXPECT_LT(on(1)[0], -0.01 * weight) << "the pile does lean on its walls";
    EXPECT_EQ(on(0)[0], 0) << "smooth";
    EXPECT_NEAR(on(1)[1], 0, 1e-12 * weight);
    const auto overlap = overlaps(simulation);
    EXPECT_GT(overlap.contacts, simulation.state().n_own);
    EXPECT_LT(overlap.mean, 1e-2);
}

/// At rest every grain with contacts is in balance and obeys Coulomb: moments and forces of the contacts' impulses against gravity's.
TEST(Pile, AtRestEveryGrainIsInBalance) {
    const double h = 5e-3, mu = 0.4;
    SceneBuilder b(mu);
    auto settings = solver(h, 100);
    b.box(8, 4, {RadiusLaw::Kind::uniform, 0.3, 0.4}, 6).stage(settings);
    settings.tolerance = 1e-9;
    settings.max_sweeps = 200'000;
    settings.check_every = 100;
    b.stage(settings);
    SerialRun run(b.scene());
    auto& simulation = run.simulation();
    run.steps(600);
    simulation.start_stage(1);
    run.steps(5);
    const auto& state = run.state();
    std::vector<Vec<2>> force(static_cast<std::size_t>(state.n_own), Vec<2>::Zero());
    std::vector<double> moment(force.size(), 0.0);
    for (const auto& c : run.loaded_contacts()) {
        const Vec<2> n(c.normal[0], c.normal[1]);
        const Vec<2> r = c.r_n * n + c.r_t[0] * Vec<2>(-n[1], n[0]);
        EXPECT_LE(std::abs(c.r_t[0]), mu * c.r_n * (1 + 1e-12));
        force[static_cast<std::size_t>(c.lo)] += r;
        moment[static_cast<std::size_t>(c.lo)] += c.r_t[0];
        if (c.hi < wall_key) {
            force[static_cast<std::size_t>(c.hi)] -= r;
            moment[static_cast<std::size_t>(c.hi)] += c.r_t[0];
        }
    }
    for (const auto& row : simulation.grain_rows()) {
        const auto i = static_cast<std::size_t>(row.id);
        const double weight = row.mass * g * h;
        // What is out of balance moves: a thousandth of a weight may, while the pile still creeps (and see the energy below).
        EXPECT_LT((force[i] + Vec<2>(0, -weight)).norm(), 1e-3 * weight) << "grain " << row.id;
        EXPECT_LT(std::abs(moment[i]), 1e-3 * weight) << "grain " << row.id;
    }
    EXPECT_LT(energies(simulation).kinetic, 1e-8 * simulation.total_mass() * g * simulation.mean_radius());
}

} // namespace
} // namespace nappe::test::pile_test
