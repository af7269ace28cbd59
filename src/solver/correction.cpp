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
//
// "A step" is here what has one geometry: a substep, or all that keep its normals, corrected at their end.

#include "solver/simulation.hpp"

#include <algorithm>

namespace nappe {

/// Fills correction_ after the solve of a substep, the last with its geometry: velocities w that `move_apart` moves grains
/// by. Pre: `note_gain` after the solve of each substep since the last correction. @param sweeps of these solves together
template <int D>
void Simulation<D>::correct_positions(double h, int sweeps) {
    const auto lap = watch_.lap(Timed::sweep);
    const int passes = std::max(4, sweeps / 5);
    correction_.resize(state_.u.size());
    for (std::size_t i = 0; i < correction_.size(); ++i) {
        correction_[i] = {};
        correction_[i].inv_m = state_.u[i].inv_m;
    }
    contacts_.begin_correction(state_.u, h, settings().position_correction);
    solver_.correct(contacts_, domain_.halo(), correction_, passes);
    counters_.relaxations += passes * contacts_.n_active();
    const double lifted = solver_.sum_over_grains([&](LocalId i) {
        double sum = 0;
        for (int d = 0; d < D; ++d) {
            sum -= scene_.gravity[d] * correction_[i].v[d];
        }
        return h * state_.mass[i] * sum;
    });
    const double dissipated = lifted > 0 ? dissipation() : 0.0;
    const double affordable = dissipated > 0 ? dissipated / lifted : 0.0;
    const double factor = lifted > 0 && affordable < 1 ? affordable : 1.0;
    for (auto& w : correction_) {
        for (int d = 0; d < D; ++d) {
            w.v[d] *= factor;
        }
    }
    lift_ = factor * lifted;
}

template <int D>
void Simulation<D>::move_apart(double h) {
    correction_work_ += lift_;
    for (LocalId i = 0; i < state_.n_held(); ++i) {
        for (int d = 0; d < D; ++d) {
            state_.x[i][d] += h * correction_[i].v[d];
            state_.mid[i].x[d] = state_.x[i][d];
        }
    }
}

/// Adds what the grains gained in the substep in hand, kinetic and potential, tile by tile.
template <int D>
void Simulation<D>::note_gain(double h) {
    const double theta = settings().theta;
    const auto& tiles = candidates_.tiles;
    gains_.resize(tiles.size());
    for (std::size_t t = 0; t < tiles.size(); ++t) {
        double of_tile = 0;
        for (LocalId i = tiles[t].grains_begin; i < tiles[t].grains_end; ++i) {
            const auto &u = state_.u[i], &u_old = state_.u_old[i];
            double kinetic = 0, fallen = 0;
            for (int d = 0; d < D; ++d) {
                kinetic += u.v[d] * u.v[d] - u_old.v[d] * u_old.v[d];
                fallen += scene_.gravity[d] * (theta * u.v[d] + (1 - theta) * u_old.v[d]);
            }
            for (int k = 0; k < n_spin<D>; ++k) {
                kinetic += 0.5 * (u.s[k] * u.s[k] - u_old.s[k] * u_old.s[k]); // I = m r²/2
            }
            of_tile += state_.mass[i] * (0.5 * kinetic - h * fallen);
        }
        gains_[t] += of_tile;
    }
}

/// **Collective.** What contacts took from the grains since the last correction [J]: the work of gravity and of walls that
/// did not become kinetic energy.
template <int D>
double Simulation<D>::dissipation() {
    ExactSum sum;
    for (const double gain : gains_) {
        sum.add(-gain);
    }
    for (const std::size_t t : reported_tiles_) {
        double of_tile = 0;
        contacts_.for_each_summed(t, [&](LocalId, LocalId b, const Vec<D>& n, double r_n, double r_t) {
            if (b >= state_.n_held()) {
                const auto w = static_cast<std::size_t>(walls_.feature(b - state_.n_held()).wall);
                of_tile += (r_n * n + r_t * Vec<D>(-n[1], n[0])).dot(0.5 * (walls_.v_old[w] + walls_.v[w]));
            }
        });
        sum.add(of_tile);
    }
    comm_.sum(sum.limbs());
    return sum.value();
}

template void Simulation<2>::note_gain(double);
template void Simulation<2>::correct_positions(double, int);
template void Simulation<2>::move_apart(double);

} // namespace nappe
