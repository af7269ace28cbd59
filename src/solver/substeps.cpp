// A step in parts: each with its own share of the sweeps and, unless the scene says otherwise, its own geometry
// (solver.substeps, solver.geometry_every).

#include "solver/simulation.hpp"

#include <algorithm>

namespace nappe {

template <int D>
std::uint32_t Simulation<D>::step(std::uint32_t outside, bool with_residual) {
    const int n = settings().substeps;
    parts_ = n;
    done_ = 0;
    predicted_ = start_.held = false;
    undo_.noted = undo_.kept = false;
    undo_.snapshot.reset();
    undo_.wall_v = walls_.v;
    drive_walls();
    watcher_.begin_step();
    while (!take_step(outside, with_residual)) {
        go_back();
        parts_ *= 2;
        watcher_.begin_step_again(parts_);
        change_substep(settings().h / parts_);
    }
    if (parts_ != n) {
        change_substep(settings().h / n); // what is reported of impulses is of the scene's own substep
    }
    sums_.end_steps(n);
    ++stage_steps_;
    ++counters_.steps;
    undo_.noted = false;
    undo_.snapshot.reset();
    return agreed_ & ~(flag::outside_first - 1);
}

/// The step in parts_ substeps; false: the watch asks for more of them.
template <int D>
bool Simulation<D>::take_step(std::uint32_t outside, bool with_residual) {
    const auto& settings = this->settings();
    Solve solve{settings.h / parts_, (settings.sweeps + settings.substeps - 1) / settings.substeps, outside, false};
    unconverged_before_ = counters_.unconverged;
    shorter_ = false;
    for (done_ = 0; done_ < parts_;) {
        const int group = std::min(settings.geometry_every, parts_ - done_);
        const int end = done_ + group;
        // What is fast turns its normals: then every substep measures its own. And work is impulse times the mean of a
        // wall's old and new velocity: summed impulses have it only where both are the same.
        Outcome outcome = Outcome::separately;
        if (group > 1 && !some_fast_ && !walls_change_speed()) {
            solve.with_residual = with_residual && end == parts_;
            outcome = kept_substeps(group, solve);
            done_ = outcome == Outcome::taken ? end : done_;
        }
        while (outcome == Outcome::separately && done_ < end) {
            solve.with_residual = with_residual && done_ + 1 == parts_;
            outcome = substep(solve) ? Outcome::separately : Outcome::shorter;
            ++done_;
        }
        if (outcome == Outcome::shorter) {
            return false;
        }
    }
    return true;
}

template <int D>
void Simulation<D>::keep(StepStart<D>& start) const {
    start.held = true;
    start.x = state_.x;
    start.u = state_.u;
    start.rotation = state_.rotation;
    start.offset = walls_.offset;
    start.v_old = walls_.v_old;
    start.energy = energy_;
    start.sums = sums_;
    start.substeps = stage_substeps_;
    start.correction_work = correction_work_;
    start.some_fast = some_fast_;
    start.records.reset();
}

/// Impulses stay what they are.
template <int D>
void Simulation<D>::put_back(const StepStart<D>& start) {
    walls_.offset = walls_.offset_mid = start.offset;
    walls_.v_old = start.v_old;
    energy_ = start.energy;
    sums_ = *start.sums;
    stage_substeps_ = start.substeps;
    correction_work_ = start.correction_work;
    some_fast_ = start.some_fast;
    if (start.records) { // lists were renewed since: rows are others, perhaps on other ranks
        const double attraction = state_.attraction;
        const bool springs = smooth() && undo_.snapshot;
        impulse_h_ = springs ? undo_.clock.impulse_h : impulse_h_;
        domain_.distribute(*start.records, springs ? undo_.snapshot->impulses : contact_rows(), walls_.n_bodies(),
                           state_, memory_);
        state_.attraction = attraction;
        candidates_ = {};
        memory_is_set_ = true;
        impulses_stale_ = false;
        contacts_.forget();
        costs_ = {};
        set_margins();
        renew_lists();
        return;
    }
    state_.x = start.x;
    state_.u = start.u;
    state_.rotation = start.rotation;
    for (LocalId i = 0; i < state_.n_held(); ++i) { // where bonds are looked for
        for (int d = 0; d < D; ++d) {
            state_.mid[i].x[d] = state_.x[i][d];
        }
    }
}

/// Back to the start of the step, for another try: impulses are what was found until now, 0 if something was not finite; of
/// smooth contacts, what the step began with.
template <int D>
void Simulation<D>::go_back() {
    if (predicted_ && !smooth() && (agreed_ & flag::not_finite) != 0) { // smooth ones are those of the start already
        candidates();
        std::fill(candidates_.r_n.begin(), candidates_.r_n.end(), 0.0);
        std::fill(candidates_.r_t.begin(), candidates_.r_t.end(), std::array<double, D - 1>{});
        contacts_.forget();
    }
    if (predicted_ && smooth() && !(start_.held && start_.records)) { // springs are no guess: those of the start
        put_springs_back();
    }
    if (start_.held) {
        start_.held = false;
        put_back(start_);
    } else if (predicted_) { // the only substep: nothing has moved yet
        std::copy(state_.u_old.begin(), state_.u_old.end(), state_.u.begin());
        for (LocalId i = 0; i < state_.n_held(); ++i) {
            for (int d = 0; d < D; ++d) {
                state_.mid[i].x[d] = state_.x[i][d];
            }
        }
        walls_.offset_mid = walls_.offset;
    }
    predicted_ = false;
    rebuild_due_ = false;
    bounds_.kinetic.reset();
}

/// Substeps are h long from now on.
template <int D>
void Simulation<D>::change_substep(double h) {
    candidates();
    rescale_impulses(h);
    contacts_.forget();
}

/// n substeps whose contacts keep the normals of the first: gaps change by h v_n, and since neither impulses nor normals
/// do from one to the next, M⁻¹ H r is the velocity they gave, and no warm start has to pass over the contacts. If a
/// grain outran its list, was fast, or a contact that was left out came to act, all is as it was but impulses.
template <int D>
typename Simulation<D>::Outcome Simulation<D>::kept_substeps(int n, const Solve& asked) {
    const double h = asked.h;
    begin_substep();
    gains_.clear();
    StepStart<D> of_group;
    if (done_ > 0) {
        keep(of_group);
    }
    const StepStart<D>& start = done_ > 0 ? of_group : start_;
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
        solve(h, asked.sweeps, k == 1 ? Start::warm : Start::as_it_is, asked.with_residual && last);
        if (corrects()) {
            note_gain(h);
        }
        if (last) {
            if (corrects()) {
                correct_positions(h, n * asked.sweeps);
            }
            agree(h, n, faults, asked.outside, &start);
            if (shorter_) {
                return Outcome::shorter;
            }
            if ((agreed_ & (flag::outran_list | flag::missed_contact | flag::fast)) != 0) {
                ++counters_.redone_groups;
                put_back(start);
                rebuild_due_ = (agreed_ & flag::outran_list) != 0;
                some_fast_ = (agreed_ & flag::fast) != 0;
                return Outcome::separately;
            }
            if (!heed(h, n, &start)) {
                return Outcome::shorter;
            }
            collect();
        }
        end_substep(h);
    }
    if (corrects()) {
        move_apart(h);
    }
    rebuild_due_ = (agreed_ & flag::rebuild_next) != 0;
    some_fast_ = false;
    return Outcome::taken;
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

template class Simulation<2>;

} // namespace nappe
