#pragma once
// Cuts the graph of tiles into parts of equal work with METIS. Never affects a bit of the result: only who computes it.

#include "core/tile_grid.hpp"

#include <cstdint>
#include <vector>

namespace nappe {

/// Vertices are tiles in the order of keys.
struct TileGraph {
    struct Edge {
        std::int32_t a = 0, b = 0; ///< a < b
        std::int64_t weight = 0;   ///< what is exchanged across it
    };
    std::vector<TileKey> keys;
    std::vector<std::int64_t> weight; ///< work of each tile
    std::vector<Edge> edges;
};

/// Local, and the same wherever it is called with the same graph. Returns the part of every vertex, in [0, n_parts).
/// METIS is asked where it is reliable; graphs with fewer than `least_tiles_per_part` tiles a part or without any work,
/// which it may put into one part without a word, are cut along the order of keys (columns of tiles, so across a layer)
/// instead.
std::vector<std::int32_t> partition(const TileGraph& graph, std::int32_t n_parts);

/// Largest part's work over the mean.
double imbalance(const TileGraph& graph, const std::vector<std::int32_t>& part, std::int32_t n_parts);

} // namespace nappe
