// A step in parts: each with its own share of the sweeps and, unless the scene says otherwise, its own geometry
// (solver.substeps, solver.geometry_every).

#include "solver/simulation.hpp"

#include <algorithm>

namespace nappe {

template <int D>
std::uint32_t Simulation<D>::step(std::uint32_t outside, bool with_residual) {
    const auto& settings = this->settings();
    const int n = settings.substeps;
    const int sweeps = (settings.sweeps + n - 1) / n;
    const double h = settings.h / n;
    drive_walls();
    for (int done = 0; done < n;) {
        const int group = std::min(settings.geometry_every, n - done);
        const bool residual_wanted = with_residual && done + group == n;
        // What is fast turns its normals: then every substep measures its own. And work is impulse times the mean of a
        // wall's old and new velocity: summed impulses have it only where both are the same.
        if (group == 1 || some_fast_ || walls_change_speed() ||
            !kept_substeps(h, sweeps, group, outside, residual_wanted)) {
            for (int k = 1; k <= group; ++k) {
                substep(h, sweeps, outside, residual_wanted && k == group);
            }
        }
        done += group;
    }
    ++stage_steps_;
    ++counters_.steps;
    return agreed_ & ~(flag::outside_first - 1);
}

/// All that substeps of one geometry change before they are accepted, but impulses, which a redone substep keeps anyway.
template <int D>
struct Simulation<D>::Before {
    std::vector<Vec<D>> x;
    std::vector<BodyVelocity<D>> u;
    std::vector<std::array<double, n_spin<D>>> rotation;
    std::vector<Vec<D>> offset, v_old;
    EnergySums<D> energy;
    std::int64_t substeps;
};

/// n substeps whose contacts keep the normals of the first: gaps change by h v_n, and since neither impulses nor normals
/// do from one to the next, M⁻¹ H r is the velocity they gave, and no warm start has to pass over the contacts. False: a
/// grain outran its list, was fast, or a contact that was left out came to act; then all is as it was but impulses.
template <int D>
bool Simulation<D>::kept_substeps(double h, int sweeps, int n, std::uint32_t outside, bool with_residual) {
    begin_substep(h);
    gains_.clear();
    const Before before{state_.x, state_.u, state_.rotation, walls_.offset, walls_.v_old, energy_, stage_substeps_};
    predict(h);
    const PackFaults faults = detect(h, false);
    for (int k = 1; k <= n; ++k) {
        if (k > 1) {
            {
                const auto lap = watch_.lap(Timed::geometry);
                contacts_.advance(state_.u, h);
            }
            predict_kept(h);
        }
        const bool last = k == n;
        solve(h, sweeps, k == 1 ? Start::warm : Start::as_it_is, with_residual && last);
        if (corrects()) {
            note_gain(h);
        }
        if (last) {
            if (corrects()) {
                correct_positions(h, n * sweeps);
            }
            agree(h, n, faults, outside);
            if ((agreed_ & (flag::outran_list | flag::missed_contact | flag::fast)) != 0) {
                ++counters_.redone_groups;
                restore(before);
                return false;
            }
            collect(n);
        }
        end_substep(h);
    }
    if (corrects()) {
        move_apart(h);
    }
    rebuild_due_ = (agreed_ & flag::rebuild_next) != 0;
    some_fast_ = false;
    return true;
}

/// `predict` after a substep with the same contacts: the velocities to start from are those that its impulses give.
template <int D>
void Simulation<D>::predict_kept(double h) {
    const auto lap = watch_.lap(Timed::predict);
    const double ahead = h * (1 - settings().theta);
    for (LocalId i = 0; i < state_.n_held(); ++i) {
        const BodyVelocity<D> u = state_.u[i], u_old = state_.u_old[i];
        state_.u_old[i] = u;
        for (int d = 0; d < D; ++d) {
            state_.mid[i].x[d] = state_.x[i][d] + ahead * u.v[d];
            state_.u[i].v[d] = u.v[d] + (u.v[d] - u_old.v[d]); // u - u_old = h g + M⁻¹ H r
        }
        for (int k = 0; k < n_spin<D>; ++k) {
            state_.u[i].s[k] = u.s[k] + (u.s[k] - u_old.s[k]);
        }
    }
    for (int w = 0; w < walls_.n_walls(); ++w) {
        walls_.offset_mid[w] = walls_.offset[w] + ahead * walls_.v_old[w];
    }
    place_walls();
}

template <int D>
void Simulation<D>::restore(const Before& before) {
    state_.x = before.x;
    for (LocalId i = 0; i < state_.n_held(); ++i) { // where bonds are looked for
        for (int d = 0; d < D; ++d) {
            state_.mid[i].x[d] = state_.x[i][d];
        }
    }
    state_.u = before.u;
    state_.rotation = before.rotation;
    walls_.offset = walls_.offset_mid = before.offset;
    walls_.v_old = before.v_old;
    energy_ = before.energy;
    stage_substeps_ = before.substeps;
    rebuild_due_ = (agreed_ & flag::outran_list) != 0;
    some_fast_ = (agreed_ & flag::fast) != 0;
}

template class Simulation<2>;

} // namespace nappe
