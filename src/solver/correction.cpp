// What is left of overlaps after a step, and how grains are moved apart without any energy put in
// (solver.position_correction).
//
// The velocity-level law lets overlaps stay (b = 0 where g <= 0). A second, frictionless problem on the same contacts asks
// for displacements h w that take away a share of each overlap and make none: w_n + b' >= 0, b' = share g/h where the step
// ends with g < 0, else g/h; w starts from rest and is forgotten after it has moved the grains. Velocities, and with them
// the kinetic energy, do not see it. What it changes is the potential energy: - sum m g·(h w). That is paid for: in no step
// may it be more than contacts have dissipated in the same step, or all displacements are scaled down to that. So in no
// step do grains gain energy by it, and at rest, where nothing is dissipated, nothing is lifted. (What too few sweeps give
// back in a later step, as an elastic body would, is the sweeps' own affair: then nothing is lifted either.)

#include "solver/simulation.hpp"

namespace nappe {

/// Fills correction_ after the solve of a step: the velocities w that end_substep moves grains by.
template <int D>
void Simulation<D>::correct_positions(double h, int sweeps) {
    const double share = settings().position_correction;
    if (!(share > 0)) {
        return;
    }
    const auto lap = watch_.lap(Timed::sweep);
    correction_.resize(state_.u.size());
    for (std::size_t i = 0; i < correction_.size(); ++i) {
        correction_[i] = {};
        correction_[i].inv_m = state_.u[i].inv_m;
    }
    contacts_.begin_correction(state_.u, h, share);
    solver_.correct(contacts_, domain_.halo(), correction_, sweeps);
    counters_.relaxations += sweeps * contacts_.n_active();
    const double lifted = solver_.sum_over_grains([&](LocalId i) {
        double sum = 0;
        for (int d = 0; d < D; ++d) {
            sum -= scene_.gravity[d] * correction_[i].v[d];
        }
        return h * state_.mass[i] * sum;
    });
    const double dissipated = lifted > 0 ? step_dissipation(h) : 0.0;
    const double affordable = dissipated > 0 ? dissipated / lifted : 0.0;
    const double factor = lifted > 0 && affordable < 1 ? affordable : 1.0;
    for (auto& w : correction_) {
        for (int d = 0; d < D; ++d) {
            w.v[d] *= factor;
        }
    }
    lift_ = factor * lifted;
}

/// What contacts took from the grains in this step [J]: the work of gravity and of walls that did not become kinetic
/// energy.
template <int D>
double Simulation<D>::step_dissipation(double h) {
    const double theta = settings().theta;
    const double gained = solver_.sum_over_grains([&](LocalId i) {
        const auto &u = state_.u[i], &u_old = state_.u_old[i];
        double kinetic = 0, fallen = 0;
        for (int d = 0; d < D; ++d) {
            kinetic += u.v[d] * u.v[d] - u_old.v[d] * u_old.v[d];
            fallen += scene_.gravity[d] * (theta * u.v[d] + (1 - theta) * u_old.v[d]);
        }
        for (int k = 0; k < n_spin<D>; ++k) {
            kinetic += 0.5 * (u.s[k] * u.s[k] - u_old.s[k] * u_old.s[k]); // I = m r²/2
        }
        return state_.mass[i] * (0.5 * kinetic - h * fallen);
    });
    ExactSum by_walls;
    for (const std::size_t t : reported_tiles_) {
        double of_tile = 0;
        contacts_.for_each(t, [&](LocalId, LocalId b, const Vec<D>& n, double r_n, double r_t) {
            if (b >= state_.n_held()) {
                const auto w = static_cast<std::size_t>(walls_.feature(b - state_.n_held()).wall);
                of_tile += (r_n * n + r_t * Vec<D>(-n[1], n[0])).dot(0.5 * (walls_.v_old[w] + walls_.v[w]));
            }
        });
        by_walls.add(of_tile);
    }
    comm_.sum(by_walls.limbs());
    return by_walls.value() - gained;
}

template void Simulation<2>::correct_positions(double, int);
template double Simulation<2>::step_dissipation(double);

} // namespace nappe
