// Nothing goes through anything unnoticed: what a step looks at before it is accepted (core/passage.hpp), and what the
// user is told.

#include "core/error.hpp"
#include "solver/simulation.hpp"

#include <fmt/format.h>

namespace nappe {

/// Smooth steps call this only if something may be found. Which other steps look follows from the step's number and from flags that all ranks share, so that a run ends in the same
/// step on any number of ranks.
template <int D>
std::uint32_t Simulation<D>::look_for_passages(double h, int n) {
    const auto lap = watch_.lap(Timed::check);
    constexpr std::int64_t slow_ones = static_cast<std::int64_t>(1 / slow_stride);
    const double theta = settings().theta;
    const bool first = stage_substeps_ == 0; // comes from where the stage found it, not from another step's mid
    // stage_substeps_ counts the substeps before the last one of the n.
    const bool all = smooth() || stage_substeps_ / slow_ones * slow_ones > stage_substeps_ - n;
    passage_ = {};
    if ((all || some_fast_) && !settings().unsafe) { // springs may be too soft, and the overlap is told of
        passage_ = find_passage(state_, candidates_, first ? h * (1 - theta) : h, all);
    }
    const Passage of_wall = find_wall_passage(state_, candidates_, walls_, reported_tiles_, h * theta);
    if (of_wall.lo < passage_.lo) {
        passage_ = of_wall;
    }
    return passage_.lo != Passage::none ? flag::passed : 0;
}

template <int D>
void Simulation<D>::fail_of_passage(const std::string& where) const {
    const auto who = -comm_.max(-passage_.lo);
    const bool mine = who == passage_.lo;
    const bool of_wall = comm_.bit_or(mine && passage_.wall >= 0 ? 1u : 0u) != 0;
    if (of_wall) {
        throw_through_wall(who, mine ? walls_.name(passage_.wall) : std::string(), where);
    }
    const auto partner = -comm_.max(-(mine ? passage_.hi : Passage::none));
    throw NumericalFailure(fmt::format("the centre of one of the grains {} and {} came into the other, or went through "
                                       "it, in {}, at {}; take a smaller solver.h if they are fast, {} if they are "
                                       "pressed together",
                                       who, partner, where, place_of(who),
                                       smooth() ? "a larger k_n of their law" : "more solver.sweeps"));
}

/// @param name of the wall on the rank that has grain `who`, "" elsewhere
template <int D>
void Simulation<D>::throw_through_wall(GlobalId who, const std::string& name, const std::string& where) const {
    throw NumericalFailure(fmt::format(
        "the centre of grain {} went through wall '{}' in {}, at {}: overlaps grow without bound there; take {} or a "
        "smaller solver.h, or, if walls close on the grain, leave it room: no impulse solves that",
        who, comm_.first_error(name), where, place_of(who),
        smooth() ? "a larger k_n of the law with that wall" : "more solver.sweeps"));
}

template class Simulation<2>;

} // namespace nappe
