#include "solver/tile_sweep.hpp"

#include <unordered_map>

namespace nappe {

template <int D>
void TileSweep<D>::order_tiles(const CandidateSet<D>& candidates, bool with_bodies) {
    order_.build(candidates);
    large_ = candidates.has_large() ? candidates.tiles.size() - 1 : no_tile;
    grains_.clear();
    for (const auto& tile : candidates.tiles) {
        grains_.emplace_back(tile.grains_begin, tile.grains_end);
    }
    bodies_.clear();
    around_.clear();
    shared_.clear();
    if (with_bodies) {
        list_bodies(candidates);
    }
}

/// fused_pass opens the first three layers before messages of the first colour are taken.
template <int D>
void TileSweep<D>::find_early(const Halo<D>& halo) {
    constexpr int in_time = 3;
    std::vector<LocalId> rows(halo.received_rows().begin(), halo.received_rows().end());
    std::sort(rows.begin(), rows.end());
    early_.clear();
    is_early_.assign(grains_.size(), false);
    for (int layer = in_time; layer <= order_.last_layer(); ++layer) {
        for (int colour = 0; colour < n_tile_colours<D>; ++colour) {
            for (const auto row : order_.tiles(layer, colour)) {
                const auto t = static_cast<std::size_t>(row);
                const auto first = std::lower_bound(rows.begin(), rows.end(), grains_[t].first);
                if (first != rows.end() && *first < grains_[t].second) {
                    early_.push_back(t);
                    is_early_[t] = true;
                }
            }
        }
    }
}

template <int D>
void TileSweep<D>::list_bodies(const CandidateSet<D>& candidates) {
    std::unordered_map<TileKey, std::int32_t> row_of;
    row_of.reserve(candidates.tiles.size());
    for (std::size_t t = 0; t < candidates.tiles.size(); ++t) {
        row_of.emplace(candidates.tiles[t].key, static_cast<std::int32_t>(t));
    }
    auto& bodies = bodies_.items;
    for (const auto& tile : candidates.tiles) {
        const auto begin = static_cast<std::ptrdiff_t>(bodies.size());
        for (auto c = tile.candidates_begin; c < tile.candidates_end; ++c) {
            bodies.push_back(candidates.a[c]);
            bodies.push_back(candidates.b[c]);
        }
        std::sort(bodies.begin() + begin, bodies.end());
        bodies.erase(std::unique(bodies.begin() + begin, bodies.end()), bodies.end());
        bodies_.end_list();
        around_.items.push_back(row_of.at(tile.key));
        for (const TileKey key : TileGrid<D>::ring(tile.key)) {
            if (const auto found = row_of.find(key); found != row_of.end()) {
                around_.items.push_back(found->second);
            }
        }
        around_.end_list();
        shared_.push_back(tile.interface);
    }
}

template class TileSweep<2>;

} // namespace nappe
