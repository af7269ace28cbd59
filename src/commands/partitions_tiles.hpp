#pragma once
// Samples too large to make here: what a sweep on many ranks would do, from tiles alone. A tile inside a sample does on
// average the same everywhere, so its share is measured on a smaller sample and set on the tiles of the larger profile.

#include "parallel/partition_counts.hpp"
#include "parallel/tile_graph.hpp"

#include <array>
#include <utility>
#include <vector>

namespace nappe {

/// A tile and the part of its area inside the profile.
struct FilledTile {
    TileKey key = 0;
    double fill = 0; ///< in (0, 1]
};

/// Local. The tiles that a profile covers, in the order of keys; slivers that could hold no grain are left out.
/// @param least_area of a tile's share for it to count [m²]
std::vector<FilledTile> fill_profile(const std::vector<Vec<2>>& profile, const TileGrid<2>& grid, double least_area);

/// The mean over tiles that are full and have nothing but full tiles around them.
struct TileStatistics {
    std::int64_t tiles = 0; ///< that were taken
    double grains = 0;
    double relaxations = 0; ///< in a sweep
    /// Grains that the tile's candidates touch, by the tiles of its ring (bits, in the order of TileGrid::ring) whose
    /// owners hold them: how many of them another part hears of follows from who owns the ring, and from nothing else.
    std::vector<std::pair<std::uint32_t, double>> touched;
    std::array<double, TileGrid<2>::n_ring> links{}; ///< candidates shared with each tile of the ring, owned by either
};

/// Local. Pre as for count_partition. Throws InputError if no tile of the sample is inside it.
TileStatistics measure_tiles(const State<2>& state, const TileGrid<2>& grid, const CandidateSet<2>& candidates,
                             const std::vector<std::int64_t>& relaxations, const std::vector<FilledTile>& tiles);

/// Local. What the graph of a sample made of such tiles would be.
TileGraph tile_graph(const TileStatistics& mean, const std::vector<FilledTile>& tiles);

/// Local. Expected counts, rounded; a message of less than half a grain is none. @param part of every tile
PartitionCounts<2> count_partition(const TileStatistics& mean, const std::vector<FilledTile>& tiles,
                                   const std::vector<std::int32_t>& part, std::int32_t n_parts);

} // namespace nappe
