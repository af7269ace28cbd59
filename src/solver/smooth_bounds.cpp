// What other steps look at in every grain and pair, a smooth one looks at only where the fastest grain could have made a
// difference since it was looked at last: bounds that hold for all, so that what is found, and when, is the same on any
// number of ranks.

#include "solver/simulation.hpp"

#include <cmath>
#include <limits>

namespace nappe {

namespace {

constexpr double round_up = 1 + 1e-9; // of a bound, for what its sums have lost

} // namespace

/// Gaps from which on pairs do without a lane [m]: the fewer have one, the sooner the others are looked at again.
template <int D>
double Simulation<D>::near_gap() const {
    constexpr double steps = 32, least = 1.0 / 256, most = 1.0 / 8; // of the skin
    const double wanted = steps * bounds_.pace;
    return wanted < least * skin_ ? least * skin_ : wanted > most * skin_ ? most * skin_ : wanted;
}

template <int D>
double Simulation<D>::depth_share() const {
    return 0.5 * scene_.watch.overlap.limit;
}

/// Whether the fastest grain is too slow for any of those that `check` and `look_for_passages` look for. Adds the step to
/// the bounds.
template <int D>
bool Simulation<D>::nothing_to_look_for(double h, const Moved& moved) {
    double of_walls = 0;
    bool in_margins = true;
    for (int w = 0; w < walls_.n_walls(); ++w) {
        const double way = h * walls_.v[w].norm();
        of_walls = way > of_walls ? way : of_walls;
        const Vec<D> at = walls_.offset_mid[w] + 2 * h * walls_.v[w] - walls_.offset_ref[w];
        in_margins = in_margins && at.norm() <= walls_.margin[w];
    }
    const double way = h * std::sqrt(moved.fastest_squared) * round_up;
    const double nearer = way + (way > of_walls ? way : of_walls);
    const double depth = depth_share() + (moved.met.deeper + nearer) / r_min_;
    const double limit = scene_.watch.overlap.limit < 1 ? scene_.watch.overlap.limit : 1.0;
    bounds_.shallow = depth * round_up < limit;
    bounds_.pace = nearer;
    bounds_.approached += nearer;
    bounds_.drifted += way;
    return moved.zeros == 0 && bounds_.shallow && in_margins && !scene_.watch.bounds && !some_fast_ &&
           (bounds_.drifted + way) * round_up < bounds_.least_room;
}

/// How far any grain is from leaving its margin [m], at the end of a step that `check` found nothing in.
template <int D>
double Simulation<D>::least_room(double h) const {
    const double falling = h * h * scene_.gravity.norm();
    double least = std::numeric_limits<double>::infinity();
    for (LocalId i = 0; i < state_.n_own; ++i) {
        double way2 = 0;
        for (int d = 0; d < D; ++d) {
            const double way = state_.mid[i].x[d] + h * state_.u[i].v[d] - state_.x_ref[i][d];
            way2 += way * way;
        }
        const double margin = state_.margin[i];
        const double room = margin - (falling < 0.25 * margin ? falling : 0.25 * margin) - std::sqrt(way2);
        least = room < least ? room : least;
    }
    return least;
}

/// What other steps look at in every one. Bounds start anew.
template <int D>
std::uint32_t Simulation<D>::look_closely(double h, const PackFaults& faults) {
    settle_records();
    std::uint32_t flags = check(h, 1, faults, nullptr) | look_for_passages(h, 1);
    // Who is deep in another may be through a step later.
    flags = (flags & ~flag::fast) | (bounds_.shallow ? 0 : flag::fast);
    bounds_.least_room = least_room(h);
    bounds_.drifted = 0;
    return flags;
}

template double Simulation<2>::near_gap() const;
template double Simulation<2>::depth_share() const;
template bool Simulation<2>::nothing_to_look_for(double, const Moved&);
template std::uint32_t Simulation<2>::look_closely(double, const PackFaults&);

} // namespace nappe
