// The time step: Moreau–Jean's theta-scheme (seeds/000 eq. 3, 4 and table 1), non-smooth contacts solved by tiles.
//
//     q_mid  = q_i + h (1 - theta) v_i                 positions where contacts are detected
//     v_free = v_i + h g                               gravity is constant: theta has no part in it
//     v_i+1  = v_free + M^-1 H r,  r from the contact law     (contact_solver.cpp, disk_sweep.inl)
//     q_i+1  = q_i + h theta v_i+1 + h (1 - theta) v_i
//
// Departs from the source in nothing but the order of relaxation. Copies of grains on several ranks go through the same
// operations and stay equal, so that positions are never sent between rebuilds.

#include "core/contact_geometry.hpp"
#include "core/error.hpp"
#include "solver/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace nappe {

/// False: the whole step is to be done again with more substeps.
template <int D>
bool Simulation<D>::substep(const Solve& asked) {
    if (smooth()) {
        return smooth_substep(asked);
    }
    const double h = asked.h;
    begin_substep();
    bool activate_all = false;
    for (int attempt = 1;; ++attempt) {
        predict(h);
        const PackFaults faults = detect(h, activate_all);
        solve(h, asked.sweeps, Start::warm, asked.with_residual);
        if (corrects()) {
            gains_.clear();
            note_gain(h);
            correct_positions(h, asked.sweeps);
        }
        agree(h, 1, faults, asked.outside);
        if (shorter_) {
            return false;
        }
        if ((agreed_ & (flag::outran_list | flag::missed_contact)) == 0) {
            break;
        }
        if (give_up(attempt)) {
            return false;
        }
        // Redone from the same start, but from the impulses found so far.
        if ((agreed_ & flag::outran_list) != 0) {
            redo_with_lists(h);
        } else {
            ++counters_.redone_packs;
            std::copy(state_.u_old.begin(), state_.u_old.end(), state_.u.begin());
            activate_all = true;
        }
    }
    if (!heed(h, 1, nullptr)) {
        return false;
    }
    collect();
    end_substep(h);
    if (corrects()) {
        move_apart(h);
    }
    rebuild_due_ = (agreed_ & flag::rebuild_next) != 0;
    some_fast_ = (agreed_ & flag::fast) != 0;
    return true;
}

/// Lists and bonds as the substep needs them.
template <int D>
void Simulation<D>::begin_substep() {
    const bool first = done_ == 0;
    if (rebuild_due_) {
        secure_start();
    }
    start_.held = start_.held && !first;
    if (rebuild_due_) {
        set_margins();
        renew_lists();
        rebuild_due_ = false;
    }
    if (first && parts_ > 1) {
        keep(start_);
    }
    note_start();
    find_bonds();
}

/// A rebuild within a step.
template <int D>
void Simulation<D>::renew_lists() {
    if (start_.held) {
        start_.name(state_);
    }
    intact_ = false;
    rebuild();
    intact_ = true;
}

/// What all ranks find wrong with the last `n` substeps, into agreed_ and shorter_; throws if nothing helps.
template <int D>
void Simulation<D>::agree(double h, int n, const PackFaults& faults, std::uint32_t outside, const StepStart<D>* start) {
    agreed_ = check(h, n, faults, start) | look_for_passages(h, n) | outside;
    {
        const auto lap = watch_.lap(Timed::check);
        agreed_ = comm_.bit_or(agreed_);
    }
    constexpr std::uint32_t fatal = flag::not_finite | flag::through_wall | flag::too_fast | flag::passed;
    if ((agreed_ & fatal) != 0) {
        shorter_ = may_divide(scene_.watch.failure);
        if (!shorter_) {
            fail(agreed_, faults, h);
        }
    }
}

template <int D>
void Simulation<D>::end_substep(double h) {
    if (energy_wanted_) {
        collect_energy(h);
    }
    integrate(h);
    ++stage_substeps_;
}

template <int D>
void Simulation<D>::drive_walls() {
    const bool preparing = scene_.stages[static_cast<std::size_t>(stage_)].until.has_value();
    for (int w = 0; w < walls_.n_walls(); ++w) {
        walls_.v[w] = driven_velocity(scene_.walls[w], stage_, preparing, time(), time() + settings().h);
    }
}

template <int D>
bool Simulation<D>::walls_change_speed() const {
    return !std::equal(walls_.v.begin(), walls_.v.end(), walls_.v_old.begin());
}

/// Detection positions, and from the velocities of the step's start the free ones.
template <int D>
void Simulation<D>::predict(double h) {
    const auto lap = watch_.lap(Timed::predict);
    predicted_ = true;
    const double ahead = h * (1 - settings().theta);
    Vec<D> gained;
    for (int d = 0; d < D; ++d) {
        gained[d] = h * scene_.gravity[d];
    }
    for (LocalId i = 0; i < state_.n_held(); ++i) {
        const BodyVelocity<D> u = state_.u[i];
        state_.u_old[i] = u;
        for (int d = 0; d < D; ++d) {
            state_.mid[i].x[d] = state_.x[i][d] + ahead * u.v[d];
            state_.u[i].v[d] = u.v[d] + gained[d];
        }
    }
    predict_walls(ahead);
}

template <int D>
void Simulation<D>::predict_walls(double ahead) {
    for (int w = 0; w < walls_.n_walls(); ++w) {
        walls_.offset_mid[w] = walls_.offset[w] + ahead * walls_.v_old[w];
    }
    place_walls();
}

template <int D>
void Simulation<D>::place_walls() {
    for (LocalId k = 0; k < walls_.n_bodies(); ++k) {
        const auto row = static_cast<std::size_t>(state_.n_held() + k);
        const auto w = static_cast<std::size_t>(walls_.feature(k).wall);
        for (int d = 0; d < D; ++d) {
            state_.u[row].v[d] = walls_.v[w][d];
            state_.u_old[row].v[d] = walls_.v_old[w][d];
        }
        state_.material[row] = walls_.material(static_cast<int>(w));
    }
}

template <int D>
PackFaults Simulation<D>::detect(double h, bool activate_all) {
    const auto lap = watch_.lap(Timed::geometry);
    keep_impulses();
    undo_.packed = impulses_stale_ = true;
    return contacts_.pack(state_, candidates_, walls_, h, activate_all);
}

template <int D>
void Simulation<D>::solve(double h, int sweeps, Start start, bool with_residual) {
    // Quiet tiles do with the V of the first substep of a geometry.
    const bool steers = settings().tolerance || (settings().adaptive && start == Start::warm);
    const double scale = steers || with_residual ? velocity_scale(h) : 0.0;
    if (steers) {
        steering_scale_ = scale;
    }
    const auto relaxing = [&] { // seconds, without what else happens between sweeps
        const auto& s = watch_.seconds();
        const auto at = [](Timed t) { return static_cast<std::size_t>(t); };
        return s[at(Timed::sweep)] - s[at(Timed::exchange)] - s[at(Timed::residual)];
    };
    const double before = relaxing();
    SolveReport report;
    {
        const auto lap = watch_.lap(Timed::sweep);
        if (!settings().warm_start) {
            contacts_.start_cold();
        }
        if (start == Start::warm) {
            solver_.warm_start(contacts_, domain_.halo(), state_.u);
        }
        report = solver_.solve(contacts_, domain_.halo(), state_.u, settings(), sweeps, steering_scale_);
    }
    relaxing_ += relaxing() - before;
    costs_.add(contacts_, report.sweeps, solver_.tile_sweeps(), solver_.tile_seconds());
    last_residual_.reset();
    if (with_residual) {
        last_residual_ = solver_.residual(contacts_, state_.u, scale);
    }
    last_sweeps_ = report.sweeps;
    counters_.relaxations += report.relaxations;
    counters_.sweeps += report.sweeps;
    counters_.reductions += report.reductions;
    counters_.unconverged += report.converged ? 0 : 1;
    if (!report.converged && settings().at_max == SolverSettings::AtMax::stop) {
        const Suspect left = worst(least_solved());
        throw NumericalFailure(fmt::format("{} has a residual of {:.3g} after max_sweeps = {} sweeps, above the "
                                           "tolerance of {:.3g}, at {}; raise max_sweeps, take a smaller solver.h, or "
                                           "at_max = \"accept\"",
                                           where(), left.measure, settings().max_sweeps, *settings().tolerance,
                                           named(left)));
    }
}

/// V: the largest of h |g|, the RMS relative free velocity at touching contacts, and the speed of driven walls [m/s].
template <int D>
double Simulation<D>::velocity_scale(double h) const {
    ExactSum squares;
    std::int64_t n = 0;
    for (std::size_t t = 0; t < candidates_.counted_tiles().size(); ++t) {
        const auto [sum, touching] = contacts_.touching_speed(t, state_.u);
        squares.add(sum);
        n += touching;
    }
    comm_.sum(squares.limbs());
    n = comm_.sum(n);
    const double falling = h * scene_.gravity.norm();
    const double approaching = n > 0 ? std::sqrt(squares.value() / static_cast<double>(n)) : 0.0;
    double scale = falling > approaching ? falling : approaching;
    for (const auto& v : walls_.v) {
        const double driven = v.norm();
        scale = driven > scale ? driven : scale;
    }
    return scale;
}

/// What may be wrong with a substep, and whether lists will last for the next `n` of them.
template <int D>
std::uint32_t Simulation<D>::check(double h, int n, const PackFaults& faults, const StepStart<D>* start) {
    const auto lap = watch_.lap(Timed::check);
    std::uint32_t flags = faults.through_wall != PackFaults::none ? flag::through_wall : 0;
    const bool correcting = corrects();
    const double falling = n * h * (n * h) * scene_.gravity.norm(); // what gravity may add until then
    const double most = largest_margin();
    const auto check_grain = [&](LocalId i) {
        // Where the contact condition g + h v_n >= 0 looks: detection positions moved on by a whole substep, and by n
        // more.
        double here = 0, next = 0, jump = 0, stride = 0;
        for (int d = 0; d < D; ++d) {
            const double move = h * (state_.u[i].v[d] + (correcting ? correction_[i].v[d] : 0.0));
            const double at = state_.mid[i].x[d] - state_.x_ref[i][d] + move;
            const double from_start = state_.mid[i].x[d] - state_.x[i][d] + move;
            here += at * at;
            const double later = at + n * h * state_.u[i].v[d];
            next += later * later;
            jump += from_start * from_start;
            stride += move * move;
        }
        const double slow = slow_stride * state_.radius[i];
        if (stride > slow * slow) {
            flags |= flag::fast;
        }
        const double margin = state_.margin[i];
        if (!(here <= margin * margin)) {
            flags |= std::isfinite(here) ? (jump < most * most ? flag::outran_list : flag::too_fast) : flag::not_finite;
        }
        const double room = margin - (falling < 0.25 * margin ? falling : 0.25 * margin);
        if (!(next <= room * room)) {
            flags |= flag::rebuild_next;
        }
    };
    gauge_ = {};
    for (const auto& tile : candidates_.tiles) {
        for (LocalId i = tile.grains_begin; i < tile.grains_end; ++i) {
            check_grain(i);
        }
        gauge(tile, h, start); // while its grains are at hand
    }
    flags |= read_gauge(h, n, start);
    for (int w = 0; w < walls_.n_walls(); ++w) {
        const Vec<D> at = walls_.offset_mid[w] + h * walls_.v[w] - walls_.offset_ref[w];
        if (at.norm() > walls_.margin[w]) {
            flags |= flag::outran_list;
        }
        if ((at + n * h * walls_.v[w]).norm() > walls_.margin[w]) {
            flags |= flag::rebuild_next;
        }
    }
    // What has no lane gets one in time: a smooth contact acts no earlier than its disks overlap where a step begins.
    if (!smooth() && contacts_.missed_any(state_, candidates_, walls_, h)) {
        flags |= flag::missed_contact;
    }
    return flags;
}

template <int D>
void Simulation<D>::integrate(double h) {
    const auto lap = watch_.lap(Timed::integrate);
    NAPPE_ASSERT(!records_stale_, "contacts are to be recorded before mid follows the grains");
    const double later = h * settings().theta;
    const double before = h * (1 - settings().theta);
    for (LocalId i = 0; i < state_.n_held(); ++i) {
        const auto& u = state_.u[i];
        const auto& u_old = state_.u_old[i];
        for (int d = 0; d < D; ++d) {
            state_.x[i][d] += later * u.v[d] + before * u_old.v[d];
            state_.mid[i].x[d] = state_.x[i][d];
        }
        for (int k = 0; k < n_spin<D> && state_.carries.turning; ++k) {
            state_.rotation[i][k] += (later * u.s[k] + before * u_old.s[k]) / state_.radius[i];
        }
    }
    integrate_walls(h);
}

template <int D>
void Simulation<D>::integrate_walls(double h) {
    const double later = h * settings().theta, before = h * (1 - settings().theta);
    for (int w = 0; w < walls_.n_walls(); ++w) {
        walls_.offset[w] += later * walls_.v[w] + before * walls_.v_old[w];
        walls_.offset_mid[w] = walls_.offset[w];
        walls_.v_old[w] = walls_.v[w];
    }
}

/// Tiles whose contacts the series report: those with grains of cells, or with walls.
template <int D>
void Simulation<D>::find_reported_tiles() {
    reported_tiles_.clear();
    const auto tiles = candidates_.counted_tiles();
    for (std::size_t t = 0; t < tiles.size(); ++t) {
        const auto& tile = tiles[t];
        for (auto c = tile.candidates_begin; c < tile.candidates_end; ++c) {
            const LocalId a = candidates_.a[c], b = candidates_.b[c];
            if (b >= state_.n_held() || (state_.cells_of(a) | state_.cells_of(b)) != 0) {
                reported_tiles_.push_back(t);
                break;
            }
        }
    }
}

/// Adds the impulses of the last substep, or of those that had its geometry, to what the series report.
template <int D>
void Simulation<D>::collect() {
    const auto lap = watch_.lap(Timed::measure);
    const auto add = [&](LocalId a, LocalId b, const Vec<D>& normal, double r_n, double r_t) {
        if (b >= state_.n_held() || (state_.cells_of(a) | state_.cells_of(b)) != 0) {
            sums_.add(state_, a, b, normal, r_n * normal + r_t * Vec<D>(-normal[1], normal[0]));
        }
    };
    if (state_.carries.cells) {
        settle_records();
    }
    for (const std::size_t t : reported_tiles_) {
        if (state_.carries.cells) {
            contacts_.for_each_summed(t, add);
        } else {
            contacts_.for_each_of_walls(t, add);
        }
        sums_.end_tile();
    }
}

template class Simulation<2>;

} // namespace nappe
