// A step with smooth contacts (seeds/004, annex): central differences, velocities live at half steps, positions and forces
// at whole ones.
//
//     v_+ = [v_- (1 - a) + h g + h F / m] / (1 + a),   a = C h / 2m          (21)
//     w_+ = [w_- (1 - a*) + h M / I] / (1 + a*),       a* = C* h / 2I        (22)
//     x_+ = x + h v_+                                                        (23), (24): theta = 1
//
// All of it is one pass over the tiles (fused_pass.hpp).

#include "solver/simulation.hpp"

namespace nappe {

namespace {

/// Does something at its end, also if that is an exception's, unless it has been told that what it waits for holds.
template <class Otherwise>
class Unless {
public:
    explicit Unless(Otherwise otherwise) : otherwise_(otherwise) {}
    Unless(const Unless&) = delete;
    Unless& operator=(const Unless&) = delete;
    ~Unless() {
        if (!holds_) {
            otherwise_();
        }
    }
    void holds() { holds_ = true; }

private:
    Otherwise otherwise_;
    bool holds_ = false;
};

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
    const auto& tiles = candidates_.tiles;
    const auto open_rows = [&](LocalId begin, LocalId end) {
        contacts_.kernels().open_grains(grains, begin, end, gained.data());
    };
    const auto close_rows = [&](LocalId begin, LocalId end) {
        const GrainMotion motion = contacts_.kernels().close_grains(grains, begin, end, h);
        moved.fastest_squared =
            motion.fastest_squared > moved.fastest_squared ? motion.fastest_squared : moved.fastest_squared;
        moved.zeros += motion.zeros;
        return motion;
    };
    const auto close_tile = [&](std::size_t t) {
        const GrainMotion motion = close_rows(tiles[t].grains_begin, tiles[t].grains_end);
        moved.kinetic += motion.kinetic;
        for (int d = 0; d < D; ++d) {
            moved.momentum[d] += motion.momentum[d];
        }
    };
    open_rows(state_.n_own, state_.n_held());
    const bool all_at_once = !near_are_known;
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
            moved.met.touching += t < contacts_.n_counted_tiles() ? met.touching : 0;
            moved.met.deeper = met.deeper > moved.met.deeper ? met.deeper : moved.met.deeper;
        },
        close_tile);
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

/// Grains are where the step found them, with the velocities that it ends with; what it found of contacts is stored, since
/// `mid` will follow the grains.
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
    settle_records();
}

/// What the last smooth step found of its contacts and did not store. Until then `mid` is where they were found.
template <int D>
void Simulation<D>::settle_records() const {
    if (!records_stale_) {
        return;
    }
    records_stale_ = false;
    contacts_.record(state_, pressed_h_);
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
    constexpr std::int64_t scale_every = 64; // looks at energies when none has grown
    const double h = asked.h;
    begin_substep();
    if (parts_ > 1 && done_ == 0) { // later substeps change the springs that the step is taken back to
        candidates();
        undo_.packed = true;
        keep_impulses();
    }
    const bool of_scale = stage_substeps_ % scale_every == 0;
    bool of_energy = false;
    Moved moved;
    bool stands = false; // grains are where the step found them, and springs those that it ends with
    for (int attempt = 1;; ++attempt) {
        moved = {};
        PackFaults faults;
        press(h, moved, faults);
        std::uint32_t flags = asked.outside | (may_have_grown(h, moved) ? flag::grown : 0);
        stands = !nothing_to_look_for(h, moved) || faults.through_wall != PackFaults::none;
        if (stands) {
            step_back();
            flags |= look_closely(h, faults);
        }
        {
            const auto lap = watch_.lap(Timed::check);
            agreed_ = comm_.bit_or(flags);
        }
        constexpr std::uint32_t told = fatal | flag::outran_list | flag::deep | flag::outside | flag::grown;
        const bool looked = stands;
        if (!stands && (agreed_ & told) != 0) { // found by another rank
            step_back();
            stands = true;
            gauge_ = {};
        }
        of_energy = of_scale || (agreed_ & flag::grown) != 0;
        if (!looked && of_energy) {
            gauge_ = {};
            for (const auto& tile : candidates_.tiles) {
                gauge(tile, h, nullptr);
            }
        }
        if ((agreed_ & fatal) != 0) {
            contacts_.swap_springs(); // whatever comes of it, it starts from these
            shorter_ = may_divide(scene_.watch.failure);
            if (!shorter_) {
                fail(agreed_, faults, h);
            }
            return false;
        }
        if ((agreed_ & flag::outran_list) == 0) {
            break;
        }
        contacts_.swap_springs();
        if (give_up(attempt)) {
            return false;
        }
        redo_with_lists(h);
    }
    if ((agreed_ & (flag::deep | flag::outside)) != 0 || of_energy) {
        Unless taken([&] { contacts_.swap_springs(); });
        if (!heed(h, 1, nullptr, of_scale ? EnergyLook::remember : of_energy ? EnergyLook::judge : EnergyLook::none)) {
            return false;
        }
        taken.holds();
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
    bounds_.kinetic = moved.kinetic;
    rebuild_due_ = (agreed_ & flag::rebuild_next) != 0;
    some_fast_ = (agreed_ & flag::fast) != 0;
    return true;
}

template void Simulation<2>::settle_records() const;
template bool Simulation<2>::smooth_substep(const Solve&);

} // namespace nappe
