#pragma once
// From positions at a rebuild to the candidates, coloured: a pure function of x_ref, margins, ids, radii and walls.

#include "core/contact_set.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace nappe {

/// Local. Fills `set` anew: finds every pair of a grain of an owned tile with a held grain of higher id, or with a wall, whose surfaces
/// are nearer than the sum of their margins and the range of cohesion, puts them in the order of CandidateSet and gives each the impulse that
/// `memory` has for it. Pre: state.x_ref, margin and radius of held grains are set, rows [0, n_own) sorted by (tile,
/// id), and so are the ghosts.
template <int D>
void find_candidates(const State<D>& state, const TileGrid<D>& grid, const Walls<D>& walls,
                     const ContactMemory<D>& memory, CandidateSet<D>& set);

/// The same, as a value.
template <int D>
CandidateSet<D> find_candidates(const State<D>& state, const TileGrid<D>& grid, const Walls<D>& walls,
                                const ContactMemory<D>& memory = {}) {
    CandidateSet<D> set;
    find_candidates(state, grid, walls, memory, set);
    return set;
}

/// Local. Splits contacts, given in canonical order, into classes that share no grain: each goes into the first class
/// where both its grains are free (in blocks of 64 classes). `colour` becomes the class of each; bodies >= n_grains
/// (walls) are never in the way. `used` is scratch over grains, all zero before and after, kept by the caller so that a
/// tile costs only its own contacts.
void colour_contacts(std::span<const LocalId> a, std::span<const LocalId> b, LocalId n_grains,
                     std::vector<std::uint64_t>& used, std::vector<std::int32_t>& colour);

} // namespace nappe
