#pragma once
// From what tiles do and what they share to the graph that is cut: one way for the running domain and for whoever asks
// how another number of ranks would do.

#include "core/contact_set.hpp"
#include "core/state.hpp"
#include "parallel/partition.hpp"

#include <vector>

namespace nappe {

/// Load of an owned tile since the last look at the balance: relaxations, or nanoseconds.
struct TileWork {
    TileKey key = 0;
    std::int64_t weight = 0;
};

/// What two tiles share; either order.
struct TileLink {
    TileKey a = 0, b = 0;
    std::int64_t contacts = 0; ///< candidates between the two tiles
};

/// Local; the same graph for the same records in any order. A key may occur several times, its work adds up, and so do
/// links. Edges join tiles that lie side by side or corner to corner, of weight 1 + the contacts they share; with no
/// links at all, before any contact is known, an eighth of the smaller tile's work stands in.
template <int D>
TileGraph tile_graph(std::vector<TileWork> work, std::vector<TileLink> links);

/// Local. Candidates between tiles, for the tiles of `candidates`.
template <int D>
std::vector<TileLink> tile_links(const State<D>& state, const TileGrid<D>& grid, const CandidateSet<D>& candidates);

} // namespace nappe
