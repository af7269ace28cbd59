#pragma once
// What a sweep on many ranks would do, counted on one: work of every part by colour, and every message, as Halo would
// send it. No rank is needed for it but this one.

#include "core/contact_set.hpp"
#include "core/state.hpp"
#include "parallel/tile_directory.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace nappe {

/// One part's share of a sweep.
template <int D>
struct PartCounts {
    std::array<std::int64_t, n_tile_colours<D>> interface {}; ///< relaxations in interface tiles, by tile colour
    std::array<std::int64_t, n_tile_colours<D>> interior{};   ///< and in the others
    std::int64_t tiles = 0;
    std::int64_t grains = 0; ///< owned

    std::int64_t relaxations() const;
};

/// What one part sends to another after a colour.
struct MessageCount {
    std::int32_t from = 0, colour = 0, to = 0;
    std::int64_t grains = 0;
};

template <int D>
struct PartitionCounts {
    std::vector<PartCounts<D>> parts;
    std::vector<MessageCount> messages; ///< in the order of (from, colour, to); one sweep's
};

/// Velocities and rim speed of a grain, as a message holds them [bytes].
template <int D>
inline constexpr std::int64_t bytes_per_sent_grain = (D + n_spin<D>)*static_cast<std::int64_t>(sizeof(double));

/// Brings messages into their order and adds up those of the same ends and colour.
void merge_messages(std::vector<MessageCount>& messages);

/// Local; costs O(grains + candidates). @param state all grains, none of them a ghost @param candidates of all tiles
/// @param relaxations of each tile in a sweep, parallel to candidates.tiles @param directory the part of every tile
template <int D>
PartitionCounts<D> count_partition(const State<D>& state, const TileGrid<D>& grid, const CandidateSet<D>& candidates,
                                   std::span<const std::int64_t> relaxations, const TileDirectory& directory,
                                   std::int32_t n_parts);

} // namespace nappe
