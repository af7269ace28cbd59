// A step with smooth contacts (seeds/004, annex): central differences, velocities live at half steps, positions and forces
// at whole ones.
//
//     v_+ = [v_- (1 - a) + h g + h F / m] / (1 + a),   a = C h / 2m          (21)
//     w_+ = [w_- (1 - a*) + h M / I] / (1 + a*),       a* = C* h / 2I        (22)
//     x_+ = x + h v_+                                                        (23), (24): theta = 1
//
// All of it is one pass over the tiles. What other steps look at in every grain and pair, this one looks at only where
// the fastest grain could have made a difference since it was looked at last: bounds that hold for all, so that what is
// found, and when, is the same.

#include "solver/simulation.hpp"

#include <cmath>
#include <limits>

namespace nappe {

namespace {

constexpr double round_up = 1 + 1e-9; // of a bound, for what its sums have lost

} // namespace

/// Of each grain held; a function of what it is, so copies have their owner's.
template <int D>
void Simulation<D>::find_damping(double h) {
    damping_.resize(static_cast<std::size_t>(state_.n_held()));
    for (LocalId i = 0; i < state_.n_held(); ++i) {
        const auto& material = scene_.materials[static_cast<std::size_t>(state_.material[i])];
        const double inertia = 0.5 * state_.mass[i] * state_.radius[i] * state_.radius[i]; // of a disk
        damping_[static_cast<std::size_t>(i)] = {0.5 * h * material.damping / state_.mass[i],
                                                 0.5 * h * material.spin_damping / inertia};
    }
    damping_h_ = h;
}

template <int D>
GrainArrays Simulation<D>::grain_arrays() {
    static_assert(sizeof(Damping) == 2 * sizeof(double));
    return {state_.x.data()->data(),
            state_.mid.data()->x.data(),
            state_.u.data()->v.data(),
            state_.u_old.data()->v.data(),
            state_.carries.turning ? state_.rotation.data()->data() : nullptr,
            &damping_.data()->a};
}

/// The pass: all grains move, and springs are those of the step's end.
template <int D>
void Simulation<D>::press(double h, Moved& moved, PackFaults& faults) {
    const bool near_are_known = !contacts_.fresh() && bounds_.approached < bounds_.near;
    if (h != damping_h_ || damping_.size() != static_cast<std::size_t>(state_.n_held())) {
        find_damping(h);
    }
    predicted_ = true;
    predict_walls(0);
    const GrainArrays grains = grain_arrays();
    Vec<D> gained;
    for (int d = 0; d < D; ++d) {
        gained[d] = h * scene_.gravity[d];
    }
    const auto open_rows = [&](LocalId begin, LocalId end) {
        contacts_.kernels().open_grains(grains, begin, end, gained.data());
    };
    const auto close_rows = [&](LocalId begin, LocalId end) {
        const GrainMotion motion = contacts_.kernels().close_grains(grains, begin, end, h);
        moved.fastest_squared =
            motion.fastest_squared > moved.fastest_squared ? motion.fastest_squared : moved.fastest_squared;
        moved.zeros += motion.zeros;
    };
    const auto& tiles = candidates_.tiles;
    open_rows(state_.n_own, state_.n_held());
    // What another rank does to a grain must not come before its tile is open, whose layer may be any if no contact of this
    // rank touches a shared grain there.
    const bool all_at_once = !near_are_known || comm_.size() > 1;
    if (all_at_once) {
        const auto lap = watch_.lap(Timed::predict);
        open_rows(0, state_.n_own);
    }
    if (!near_are_known) {
        const auto lap = watch_.lap(Timed::geometry);
        bounds_.approached = 0;
        bounds_.near = near_gap();
        faults = contacts_.gather_near(state_, candidates_, walls_, h, bounds_.near);
    }
    const auto lap = watch_.lap(Timed::sweep);
    const SmoothStep step{{grains.mid, grains.u_old}, grains.u, h, depth_share(), contacts_.uniform_springs()};
    solver_.pass(
        domain_.halo(), state_.u,
        [&](std::size_t t) {
            if (!all_at_once) {
                open_rows(tiles[t].grains_begin, tiles[t].grains_end);
            }
        },
        [&](std::size_t t) {
            const SmoothTally met = contacts_.press(t, state_, candidates_, walls_, step, faults);
            moved.met.touching += met.touching;
            moved.met.deeper = met.deeper > moved.met.deeper ? met.deeper : moved.met.deeper;
        },
        [&](std::size_t t) { close_rows(tiles[t].grains_begin, tiles[t].grains_end); });
    close_rows(state_.n_own, state_.n_held());
    contacts_.swap_springs();
    impulses_stale_ = records_stale_ = true;
    pressed_h_ = h;
    costs_.add(contacts_, 1, {}, {});
    last_residual_.reset();
    last_sweeps_ = 1;
    counters_.relaxations += static_cast<std::int64_t>(moved.met.touching);
    ++counters_.sweeps;
}

/// Gaps from which on pairs do without a lane [m]: the fewer have one, the sooner the others are looked at again.
template <int D>
double Simulation<D>::near_gap() const {
    constexpr double steps = 64, least = 1.0 / 256, most = 1.0 / 8; // of the skin
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

/// Grains are where the step found them, with the velocities that it ends with.
template <int D>
void Simulation<D>::step_back() {
    for (LocalId i = 0; i < state_.n_held(); ++i) {
        for (int d = 0; d < D; ++d) {
            state_.x[i][d] = state_.mid[i].x[d];
        }
        if (state_.carries.turning) {
            state_.rotation[i][0] = state_.mid[i].rotation;
        }
    }
}

/// What the last smooth step found of its contacts and did not store. Until then `mid` is where they were found.
template <int D>
void Simulation<D>::settle_records() const {
    if (!records_stale_) {
        return;
    }
    records_stale_ = false;
    contacts_.record_all(state_, pressed_h_);
    for (LocalId i = 0; i < state_.n_held(); ++i) {
        for (int d = 0; d < D; ++d) {
            state_.mid[i].x[d] = state_.x[i][d];
        }
    }
}

/// As `substep`.
template <int D>
bool Simulation<D>::smooth_substep(const Solve& asked) {
    constexpr std::uint32_t fatal = flag::not_finite | flag::through_wall | flag::too_fast | flag::passed;
    const double h = asked.h;
    begin_substep();
    bool stands = false; // grains are where the step found them
    for (int attempt = 1;; ++attempt) {
        Moved moved;
        PackFaults faults;
        press(h, moved, faults);
        std::uint32_t flags = asked.outside;
        stands = !nothing_to_look_for(h, moved) || faults.through_wall != PackFaults::none;
        if (stands) {
            step_back();
            flags |= look_closely(h, faults);
        }
        {
            const auto lap = watch_.lap(Timed::check);
            agreed_ = comm_.bit_or(flags);
        }
        if ((agreed_ & (fatal | flag::outran_list | flag::deep | flag::outside)) == 0) {
            break;
        }
        if (!stands) {
            step_back();
            stands = true;
        }
        contacts_.swap_springs(); // whatever comes of it, it starts from these
        if ((agreed_ & fatal) != 0) {
            shorter_ = may_divide(scene_.watch.failure);
            if (!shorter_) {
                fail(agreed_, faults, h);
            }
            return false;
        }
        if ((agreed_ & flag::outran_list) == 0) {
            if (!heed(h, 1, nullptr)) {
                return false;
            }
            contacts_.swap_springs();
            break;
        }
        if (give_up(attempt)) {
            return false;
        }
        redo_with_lists(h);
    }
    collect();
    if (energy_wanted_) {
        collect_energy(h);
    }
    if (stands) {
        integrate(h);
    } else {
        integrate_walls(h);
    }
    ++stage_substeps_;
    rebuild_due_ = (agreed_ & flag::rebuild_next) != 0;
    some_fast_ = (agreed_ & flag::fast) != 0;
    return true;
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

template void Simulation<2>::settle_records() const;
template bool Simulation<2>::smooth_substep(const Solve&);

} // namespace nappe
