// Between steps: margins, and the lists that are frozen from one rebuild to the next (docs/architecture.md, "Rebuild").

#include "core/neighbours.hpp"
#include "solver/simulation.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace nappe {

/// How far each grain may go before lists are rebuilt: the skin's half for those at rest, `lookahead` steps for those
/// that move.
template <int D>
void Simulation<D>::set_margins() {
    const double most = largest_margin();
    const double ahead = settings().h * scene_.tiles.lookahead;
    for (LocalId i = 0; i < state_.n_own; ++i) {
        double v2 = 0;
        for (int d = 0; d < D; ++d) {
            v2 += state_.u[i].v[d] * state_.u[i].v[d];
        }
        const double wanted = std::max(0.5 * skin_, ahead * std::sqrt(v2));
        state_.margin[i] = std::min(wanted, most);
    }
}

/// After a grain outran its margin in this step: room for where it was going, and as much again.
template <int D>
void Simulation<D>::widen_margins(double h) {
    const double most = largest_margin();
    for (LocalId i = 0; i < state_.n_own; ++i) {
        double jump = 0;
        for (int d = 0; d < D; ++d) {
            const double apart = corrects() ? correction_[i].v[d] : 0.0;
            const double from_start = state_.mid[i].x[d] - state_.x[i][d] + h * (state_.u[i].v[d] + apart);
            jump += from_start * from_start;
        }
        const double wanted = std::max(0.5 * skin_, 2 * std::sqrt(jump));
        state_.margin[i] = std::min(std::max(state_.margin[i], wanted), most);
    }
}

/// Which law acts on each candidate, from where everything stands at the start of the step.
template <int D>
void Simulation<D>::find_bonds() {
    if (contacts_.cohesive()) {
        const auto lap = watch_.lap(Timed::geometry);
        walls_.offset_mid = walls_.offset; // where grains are too: `predict` has not been, or a rebuild followed it
        contacts_.find_bonds(state_, candidates_, walls_);
    }
}

template <int D>
void Simulation<D>::rebuild() {
    const auto lap = watch_.lap(Timed::rebuild);
    for (int w = 0; w < walls_.n_walls(); ++w) {
        walls_.offset_ref[w] = walls_.offset[w];
        // Two steps at least, so that a list made for a wall lasts for the step that asked for it.
        const double steps = std::max(2.0, scene_.tiles.lookahead);
        walls_.margin[w] = std::max(0.5 * skin_, settings().h * steps * walls_.v[w].norm());
    }
    relist();
}

/// Lists from where everything stands, with the margins that are set.
template <int D>
void Simulation<D>::relist() {
    const auto start = std::chrono::steady_clock::now();
    const bool moved = rebalance_if_due();
    if (!memory_is_set_) { // by a sample, or by a step that is done again
        memory_.keep(state_, candidates());
    }
    memory_is_set_ = false;
    domain_.rebuild(state_, walls_.n_bodies(), memory_);
    place_walls();
    find_candidates(state_, domain_.grid(), walls_, memory_, candidates_);
    memory_ = {}; // 50 bytes a grain that nobody needs until the next rebuild
    impulses_stale_ = false;
    contacts_.forget();
    domain_.build_halo(state_, candidates_);
    solver_.order_tiles(candidates_, settings().adaptive.has_value());
    if (smooth()) {
        solver_.find_early(domain_.halo());
    }
    costs_.relist(candidates_);
    find_reported_tiles();
    damping_.clear();
    bounds_ = {};
    for (LocalId i = 0; i < state_.n_own && smooth(); ++i) {
        bounds_.weighed += state_.mass[i] * scene_.gravity.norm() * mean_radius_;
    }
    ++counters_.rebuilds;
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (moved) {
        domain_.moved(seconds - rebuild_seconds_);
    } else {
        rebuild_seconds_ = seconds;
    }
}

/// Returns whether tiles moved.
template <int D>
bool Simulation<D>::rebalance_if_due() {
    const SpentTime spent{relaxing_, counters_.steps - last_balance_};
    if (spent.steps < scene_.balance.every || comm_.size() == 1) {
        return false;
    }
    const auto work =
        scene_.balance.by == BalanceSettings::By::time ? costs_.by_time(spent.relaxing) : costs_.by_work();
    const bool moved = domain_.balance(work, tile_links(state_, domain_.grid(), candidates_), spent);
    counters_.rebalanced += moved ? 1 : 0;
    last_balance_ = counters_.steps;
    relaxing_ = 0;
    costs_.clear();
    return moved;
}

template class Simulation<2>;

} // namespace nappe
