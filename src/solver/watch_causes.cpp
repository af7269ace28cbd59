// What the user is told of a step that can not be taken, or in which the watch found something: the grain, its place, the
// step, the rule and the remedy. All of it is **collective**, and all ranks get the same text.

#include "core/error.hpp"
#include "solver/simulation.hpp"

#include <fmt/format.h>

#include <cmath>

namespace nappe {

template <int D>
std::string Simulation<D>::where() const {
    const auto& stage = scene_.stages[static_cast<std::size_t>(stage_)].name;
    const auto parts = parts_ == settings().substeps ? std::string() : fmt::format(" in {} substeps", parts_);
    return fmt::format("step {} of stage '{}' (t = {:.9g} s){}", stage_steps_ + 1, stage, time(), parts);
}

/// "[x, y]", where the step found it.
template <int D>
std::string Simulation<D>::place_of(GlobalId who) const {
    std::string mine;
    for (LocalId i = 0; i < state_.n_own; ++i) {
        if (state_.id[i] == who) {
            const Vec<D> x = state_.x[i] + scene_.origin;
            mine = fmt::format("[{:.9g}, {:.9g}]", x[0], x[1]);
        }
    }
    return comm_.first_error(mine);
}

/// Local. @param b a grain, the body of a wall, or -1: nothing
template <int D>
Suspect Simulation<D>::suspect(double measure, LocalId a, LocalId b) const {
    Suspect s;
    s.measure = measure;
    s.lo = state_.id[a];
    s.hi = b >= 0 && b < state_.n_held() ? state_.id[b] : -1;
    s.wall = b >= state_.n_held() ? walls_.feature(b - state_.n_held()).wall : -1;
    for (int d = 0; d < D; ++d) {
        s.place[static_cast<std::size_t>(d)] = state_.x[a][d] + scene_.origin[d];
    }
    return s;
}

/// The worst of all ranks.
template <int D>
Suspect Simulation<D>::worst(const Suspect& mine) const {
    Suspect found;
    for (const Suspect& s : comm_.all_gather(std::vector<Suspect>{mine})) {
        found = s.worse_than(found) ? s : found;
    }
    return found;
}

/// Local. "grains 3 and 7 at [x, y]".
template <int D>
std::string Simulation<D>::named(const Suspect& s) const {
    const auto place = fmt::format("at [{:.9g}, {:.9g}]", s.place[0], s.place[1]);
    return s.hi >= 0     ? fmt::format("grains {} and {} {}", s.lo, s.hi, place)
           : s.wall >= 0 ? fmt::format("grain {} and wall '{}' {}", s.lo, walls_.name(s.wall), place)
                         : fmt::format("grain {} {}", s.lo, place);
}

/// Local. The contact of this rank with the largest residual.
template <int D>
Suspect Simulation<D>::least_solved() const {
    Suspect found;
    for (std::size_t t = 0; t < contacts_.n_tiles(); ++t) {
        contacts_.for_each_residual(t, state_.u, [&](LocalId a, LocalId b, double squared) {
            if (squared >= found.measure) {
                const Suspect now = suspect(squared, a, b);
                found = now.worse_than(found) ? now : found;
            }
        });
    }
    if (found.measure >= 0) {
        const double absolute = std::sqrt(found.measure);
        found.measure = steering_scale_ > 0 ? absolute / steering_scale_ : absolute;
    }
    return found;
}

template <int D>
std::string Simulation<D>::cause(Watched what, double growth) const {
    const auto& watch = scene_.watch;
    switch (what) {
    case Watched::overlap: {
        const Suspect s = worst(gauge_.deep);
        return fmt::format("{} overlap by {:.3g} of the smaller radius at the end of {}, beyond watch.overlap.limit = "
                           "{}; take {}",
                           named(s), s.measure, where(), watch.overlap.limit,
                           smooth() ? "a larger k_n of their law"
                                    : "more solver.sweeps, a smaller solver.h or more solver.substeps");
    }
    case Watched::energy:
        return fmt::format(
            "energy grew without work in {}, by {:.3g} of the energies of watch.energy, beyond its limit "
            "of {}, most of it between {}; take {}",
            where(), growth, watch.energy.limit, named(worst(driver())),
            smooth() ? "a smaller solver.h" : "more solver.sweeps or a smaller solver.h");
    case Watched::residual: {
        const Suspect s = worst(least_solved());
        return fmt::format("the residual has been above solver.tolerance = {} in {} steps in a row, up to {}: it is "
                           "{:.3g} between {}; raise solver.max_sweeps, take a smaller solver.h or another method",
                           *settings().tolerance, watcher_.memory().unconverged_in_row, where(), s.measure, named(s));
    }
    case Watched::bounds: {
        const Vec<D> min = watch.bounds->min + scene_.origin, max = watch.bounds->max + scene_.origin;
        return fmt::format(
            "the centre of {} is outside watch.bounds, [{}, {}] to [{}, {}], at the end of {}; look where "
            "it came from, or widen the bounds",
            named(worst(gauge_.outside)), min[0], min[1], max[0], max[1], where());
    }
    }
    return {};
}

/// All ranks throw the same error, which names the lowest grain concerned.
template <int D>
void Simulation<D>::fail(std::uint32_t flags, const PackFaults& faults, double h) const {
    if ((flags & flag::through_wall) != 0) {
        const auto who = -comm_.max(-faults.through_wall);
        throw_through_wall(who, who == faults.through_wall ? walls_.name(faults.wall) : std::string(), where());
    }
    if ((flags & flag::passed) != 0) {
        fail_of_passage(where());
    }
    GlobalId mine = PackFaults::none;
    for (LocalId i = 0; i < state_.n_own; ++i) {
        double jump = 0;
        for (int d = 0; d < D; ++d) {
            const double apart = corrects() ? correction_[i].v[d] : 0.0;
            const double move = state_.mid[i].x[d] - state_.x[i][d] + h * (state_.u[i].v[d] + apart);
            jump += move * move;
        }
        const bool finite = std::isfinite(jump) && std::isfinite(kinetic_energy(state_.u[i], state_.mass[i]));
        const bool bad = (flags & flag::not_finite) != 0 ? !finite : !(jump < std::pow(largest_margin(), 2));
        if (bad && state_.id[i] < mine) {
            mine = state_.id[i];
        }
    }
    const auto who = -comm_.max(-mine);
    const auto place = place_of(who);
    if ((flags & flag::not_finite) != 0) {
        throw NumericalFailure(
            fmt::format("the velocity of grain {} is not finite in {}, at {}; two grains may share a centre, or an "
                        "input number is out of proportion",
                        who, where(), place));
    }
    throw NumericalFailure(
        fmt::format("grain {} would move more than {} m in {}, from {}, farther than tiles allow; take a smaller "
                    "solver.h or a larger tiles.side",
                    who, largest_margin(), where(), place));
}

template std::string Simulation<2>::where() const;
template std::string Simulation<2>::place_of(GlobalId) const;
template Suspect Simulation<2>::suspect(double, LocalId, LocalId) const;
template Suspect Simulation<2>::worst(const Suspect&) const;
template std::string Simulation<2>::named(const Suspect&) const;
template Suspect Simulation<2>::least_solved() const;
template std::string Simulation<2>::cause(Watched, double) const;
template void Simulation<2>::fail(std::uint32_t, const PackFaults&, double) const;

} // namespace nappe
