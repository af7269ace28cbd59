// A step that failed, taken back to the bit: what a restart would go on from.

#include "core/error.hpp"
#include "solver/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace nappe {

/// Lists are those that the step will work with, and nothing else has happened.
template <int D>
void Simulation<D>::note_start() {
    if (undo_.noted) { // it has begun before
        return;
    }
    undo_.noted = true;
    undo_.packed = undo_.kept = false;
    undo_.clock = clock();
    undo_.relaxations = counters_.relaxations;
}

/// Before others than those of the start are stored with the candidates.
template <int D>
void Simulation<D>::keep_impulses() const {
    if (!undo_.noted || !undo_.packed || undo_.kept) {
        return;
    }
    undo_.kept = true;
    undo_.kept_h = impulse_h_;
    undo_.r_n = candidates_.r_n;
    undo_.r_t = candidates_.r_t;
}

/// Springs as the step in hand found them. Pre: lists as they were then, or since they were renewed.
template <int D>
void Simulation<D>::put_springs_back() {
    candidates(); // those of the start are kept now, or still there
    if (undo_.kept) {
        candidates_.r_n = undo_.r_n;
        candidates_.r_t = undo_.r_t;
        impulse_h_ = undo_.kept_h;
    }
    rescale_impulses(undo_.clock.impulse_h);
    contacts_.forget();
}

/// **Collective.** Before lists are renewed within the step.
template <int D>
void Simulation<D>::secure_start() {
    if (!undo_.noted || undo_.snapshot) {
        return;
    }
    CandidateSet<D> then = candidates();
    if (undo_.kept) {
        then.r_n = undo_.r_n;
        then.r_t = undo_.r_t;
    }
    const bool moved = start_.held;
    undo_.snapshot =
        moved ? snapshot_with(then, start_.sums.value(), start_.energy) : snapshot_with(then, sums_, energy_);
    auto& s = *undo_.snapshot;
    s.clock = undo_.clock;
    for (LocalId i = 0; i < state_.n_own; ++i) {
        const auto row = static_cast<std::size_t>(i);
        const auto& u = moved ? start_.u[row] : predicted_ ? state_.u_old[row] : state_.u[row];
        auto& grain = s.grains[row];
        grain.v = u.v;
        grain.s = u.s;
        for (int d = 0; d < D && moved; ++d) {
            grain.x[static_cast<std::size_t>(d)] = start_.x[row][d];
        }
        if (moved && !start_.rotation.empty()) {
            grain.rotation = start_.rotation[row];
        }
    }
    for (std::size_t w = 0; w < s.walls.size(); ++w) {
        for (std::size_t d = 0; d < D; ++d) {
            const auto k = static_cast<int>(d);
            s.walls[w].v[d] = undo_.wall_v[w][k];
            if (moved) {
                s.walls[w].offset[d] = start_.offset[w][k];
                s.walls[w].v_old[d] = start_.v_old[w][k];
            }
        }
    }
}

template <int D>
bool Simulation<D>::undo_step() {
    if (undo_.snapshot) {
        const Snapshot<D> start = std::move(*undo_.snapshot);
        const auto relaxations = undo_.relaxations;
        undo_.snapshot.reset();
        undo_.noted = predicted_ = false;
        resume(start);
        counters_.relaxations = relaxations;
        return true;
    }
    if (comm_.bit_or(intact_ ? 0U : 1U) != 0) {
        return false;
    }
    if (!undo_.noted) {
        return true; // it had not begun
    }
    go_back();
    put_springs_back();
    walls_.v = undo_.wall_v;
    set_clock(undo_.clock);
    counters_.relaxations = undo_.relaxations;
    undo_.noted = false;
    return true;
}

/// After so many attempts at a substep. True: the step is to be done with more substeps. Throws NumericalFailure.
template <int D>
bool Simulation<D>::give_up(int attempt) const {
    constexpr int most_attempts = 8;
    if (attempt < most_attempts) {
        return false;
    }
    if (may_divide(scene_.watch.failure)) {
        return true;
    }
    throw NumericalFailure(
        fmt::format("{} had to be redone more than {} times, since grains moved farther than foreseen "
                    "each time; take a smaller solver.h or more sweeps",
                    where(), most_attempts));
}

/// A grain outran its margin: back to the start of the substep, with wider ones.
template <int D>
void Simulation<D>::redo_with_lists(double h) {
    ++counters_.redone_lists;
    secure_start();
    widen_margins(h);
    std::copy(state_.u_old.begin(), state_.u_old.end(), state_.u.begin());
    renew_lists();
    find_bonds();
    undo_.kept = undo_.kept && !smooth(); // by candidate; there is a snapshot now
    undo_.packed = undo_.packed && !smooth();
}

template bool Simulation<2>::give_up(int) const;
template void Simulation<2>::redo_with_lists(double);
template void Simulation<2>::note_start();
template void Simulation<2>::keep_impulses() const;
template void Simulation<2>::put_springs_back();
template void Simulation<2>::secure_start();
template bool Simulation<2>::undo_step();

} // namespace nappe
