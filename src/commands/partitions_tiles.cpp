#include "commands/partitions_tiles.hpp"

#include "core/error.hpp"
#include "core/polygon.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace nappe {

namespace {

constexpr int n_ring = TileGrid<2>::n_ring;
constexpr double full = 0.999; ///< of a tile's area: round-off of the clipping aside, all of it

/// What is left of a polygon on one side of a line along an axis. Parts that fall apart stay joined by edges that
/// enclose no area.
std::vector<Vec<2>> clip(const std::vector<Vec<2>>& polygon, int axis, double at, bool keep_above) {
    std::vector<Vec<2>> kept;
    const auto inside = [&](const Vec<2>& p) { return keep_above ? p[axis] >= at : p[axis] <= at; };
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Vec<2>& p = polygon[k];
        const Vec<2>& q = polygon[(k + 1) % polygon.size()];
        if (inside(p)) {
            kept.push_back(p);
        }
        if (inside(p) != inside(q)) {
            kept.push_back(p + (at - p[axis]) / (q[axis] - p[axis]) * (q - p));
        }
    }
    return kept;
}

/// Parts of the ring, -1 where there is no tile.
std::array<std::int32_t, n_ring> ring_parts(const std::vector<FilledTile>& tiles, std::size_t t,
                                            const std::vector<std::int32_t>& part) {
    std::array<std::int32_t, n_ring> parts;
    const auto ring = TileGrid<2>::ring(tiles[t].key);
    for (std::size_t k = 0; k < ring.size(); ++k) {
        const auto it = std::lower_bound(tiles.begin(), tiles.end(), ring[k],
                                         [](const FilledTile& tile, TileKey key) { return tile.key < key; });
        parts[k] = it != tiles.end() && it->key == ring[k] ? part[static_cast<std::size_t>(it - tiles.begin())] : -1;
    }
    return parts;
}

/// The tile and all around it are full.
bool is_inside(const std::vector<FilledTile>& tiles, std::size_t t) {
    const auto ring = TileGrid<2>::ring(tiles[t].key);
    return std::all_of(ring.begin(), ring.end(), [&](TileKey key) {
        const auto it = std::lower_bound(tiles.begin(), tiles.end(), key,
                                         [](const FilledTile& tile, TileKey k) { return tile.key < k; });
        return it != tiles.end() && it->key == key && it->fill > full;
    });
}

} // namespace

std::vector<FilledTile> fill_profile(const std::vector<Vec<2>>& profile, const TileGrid<2>& grid, double least_area) {
    std::vector<FilledTile> tiles;
    const double side = grid.side();
    Vec<2> low = profile.front(), high = profile.front();
    for (const auto& p : profile) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    const auto first = grid.coordinates(low), last = grid.coordinates(high);
    for (auto cx = first[0]; cx <= last[0]; ++cx) {
        const double left = grid.corner(TileGrid<2>::pack({cx, first[1]}))[0];
        const auto column = clip(clip(profile, 0, left, true), 0, left + side, false);
        for (auto cy = first[1]; cy <= last[1] && column.size() > 2; ++cy) {
            const TileKey key = TileGrid<2>::pack({cx, cy});
            const double bottom = grid.corner(key)[1];
            const auto piece = clip(clip(column, 1, bottom, true), 1, bottom + side, false);
            const double area = piece.size() > 2 ? std::abs(signed_area(piece)) : 0.0;
            if (area > least_area) {
                tiles.push_back({key, std::min(1.0, area / (side * side))});
            }
        }
    }
    return tiles;
}

TileStatistics measure_tiles(const State<2>& state, const TileGrid<2>& grid, const CandidateSet<2>& candidates,
                             const std::vector<std::int64_t>& relaxations, const std::vector<FilledTile>& tiles) {
    double range_max = 0;
    for (std::size_t i = 0; i < state.radius.size(); ++i) {
        range_max = std::max(range_max, state.reach(static_cast<LocalId>(i)));
    }
    std::map<TileKey, std::size_t> row; // of the tiles inside
    for (std::size_t t = 0; t < tiles.size(); ++t) {
        if (is_inside(tiles, t)) {
            row.emplace(tiles[t].key, t);
        }
    }
    TileStatistics mean;
    std::map<std::uint32_t, std::int64_t> touched;
    std::vector<std::int32_t> touched_by(static_cast<std::size_t>(state.n_held()), -1);
    for (std::size_t t = 0; t < candidates.plain_tiles().size(); ++t) {
        const auto& tile = candidates.plain_tiles()[t];
        if (!row.contains(tile.key)) {
            continue;
        }
        const auto ring = TileGrid<2>::ring(tile.key);
        mean.tiles += 1;
        mean.grains += tile.grains_end - tile.grains_begin;
        mean.relaxations += static_cast<double>(relaxations[t]);
        const auto touch = [&](LocalId body) {
            const auto i = static_cast<std::size_t>(body);
            if (body >= state.n_held() || touched_by[i] == static_cast<std::int32_t>(t)) {
                return;
            }
            touched_by[i] = static_cast<std::int32_t>(t);
            const double range = state.reach(body) + range_max;
            std::uint32_t holders = 0;
            for (std::size_t k = 0; k < ring.size(); ++k) {
                holders |= grid.distance(state.x_ref[i], ring[k]) <= range ? std::uint32_t{1} << k : 0;
            }
            ++touched[holders];
        };
        for (auto c = static_cast<std::size_t>(tile.candidates_begin);
             c < static_cast<std::size_t>(tile.candidates_end); ++c) {
            touch(candidates.a[c]);
            touch(candidates.b[c]);
        }
    }
    if (mean.tiles == 0) {
        throw InputError("--tile-scale: the sample must have tiles with full tiles all around, found none; make the "
                         "sample larger (--scale) or the tiles smaller (--set tiles.side=…)");
    }
    const auto n = static_cast<double>(mean.tiles);
    mean.grains /= n;
    mean.relaxations /= n;
    for (const auto& [holders, count] : touched) {
        mean.touched.emplace_back(holders, static_cast<double>(count) / n);
    }
    // Either owner counts: a contact between two tiles is listed once, from the tile of its lower id.
    for (const auto& link : tile_links(state, grid, candidates)) {
        for (const auto& [from, to] : {std::pair(link.a, link.b), std::pair(link.b, link.a)}) {
            if (row.contains(from)) {
                const auto ring = TileGrid<2>::ring(from);
                const auto k = std::find(ring.begin(), ring.end(), to) - ring.begin();
                mean.links[static_cast<std::size_t>(k)] += static_cast<double>(link.contacts) / n;
            }
        }
    }
    return mean;
}

TileGraph tile_graph(const TileStatistics& mean, const std::vector<FilledTile>& tiles) {
    std::vector<TileWork> work;
    std::vector<TileLink> links;
    for (const auto& tile : tiles) {
        work.push_back({tile.key, std::llround(tile.fill * mean.relaxations)});
        const auto ring = TileGrid<2>::ring(tile.key);
        for (std::size_t k = 0; k < ring.size(); ++k) {
            if (ring[k] > tile.key) { // links to tiles that are not there are passed over
                links.push_back({tile.key, ring[k], std::llround(tile.fill * mean.links[k])});
            }
        }
    }
    return tile_graph<2>(std::move(work), std::move(links));
}

PartitionCounts<2> count_partition(const TileStatistics& mean, const std::vector<FilledTile>& tiles,
                                   const std::vector<std::int32_t>& part, std::int32_t n_parts) {
    PartitionCounts<2> counts;
    counts.parts.resize(static_cast<std::size_t>(n_parts));
    constexpr double unit = 1 << 20; // expected grains are added up in whole numbers: any order, one sum
    for (std::size_t t = 0; t < tiles.size(); ++t) {
        const auto colour = TileGrid<2>::colour(tiles[t].key);
        const auto owner = part[t];
        const auto around = ring_parts(tiles, t, part);
        double heard = 0; // grains that any other part hears of
        for (std::size_t k = 0; k < around.size(); ++k) {
            const auto to = around[k];
            if (to < 0 || to == owner || std::find(around.begin(), around.begin() + k, to) != around.begin() + k) {
                continue;
            }
            std::uint32_t theirs = 0;
            for (std::size_t l = k; l < around.size(); ++l) {
                theirs |= around[l] == to ? std::uint32_t{1} << l : 0;
            }
            double grains = 0;
            for (const auto& [holders, count] : mean.touched) {
                grains += (holders & theirs) != 0 ? tiles[t].fill * count : 0.0;
            }
            heard += grains;
            counts.messages.push_back({owner, colour, to, std::llround(unit * grains)});
        }
        auto& of_part = counts.parts[static_cast<std::size_t>(owner)];
        (heard < 0.5 ? of_part.interior : of_part.interface)[static_cast<std::size_t>(colour)] +=
            std::llround(tiles[t].fill * mean.relaxations);
        of_part.tiles += 1;
        of_part.grains += std::llround(tiles[t].fill * mean.grains);
    }
    merge_messages(counts.messages);
    for (auto& m : counts.messages) {
        m.grains = std::llround(static_cast<double>(m.grains) / unit);
    }
    std::erase_if(counts.messages, [](const auto& m) { return m.grains == 0; });
    return counts;
}

} // namespace nappe
