#pragma once
// What no contact law allows and a step may still do, by too few sweeps or too long a stride: a grain that comes through
// another, or through a wall. Found after the fact and told; never mended in silence.

#include "core/contact_set.hpp"

#include <limits>
#include <span>

namespace nappe {

/// The first offender by id; `none` if there is none.
struct Passage {
    static constexpr GlobalId none = std::numeric_limits<GlobalId>::max();
    GlobalId lo = none; ///< a grain
    GlobalId hi = none; ///< the other grain
    int wall = -1;      ///< or the wall
};

/// Share of its radius that a grain may move in one step and still be slow.
inline constexpr double slow_stride = 1.0 / 16;

/// Local. A pair of grains one of whose centres was within the other on the straight way to State::mid, `seconds` long at
/// State::u_old. @param all also pairs of which neither is fast: for them every 1/slow_stride-th step is soon enough,
/// since the way through a disk's middle is two radii long and they approach by an eighth of the larger at most.
template <int D>
Passage find_passage(const State<D>& state, const CandidateSet<D>& candidates, double seconds, bool all);

/// Local. A grain whose centre goes through a wall on the way from State::mid to the end of the step, `seconds` long at
/// State::u: the next lists would take the side it is on then for the one it belongs to.
/// @param tiles into candidates.tiles: those to look at
template <int D>
Passage find_wall_passage(const State<D>& state, const CandidateSet<D>& candidates, const Walls<D>& walls,
                          std::span<const std::size_t> tiles, double seconds);

} // namespace nappe
