#include "solver/tile_order.hpp"

#include <unistd.h>

#include <algorithm>
#include <unordered_map>

namespace nappe {

namespace {

/// Layers behind those that are set already: by distance, breadth first.
template <int D>
void spread(const CandidateSet<D>& candidates, const std::unordered_map<TileKey, std::int32_t>& row_of,
            std::vector<int>& layer) {
    std::vector<std::int32_t> front;
    for (std::size_t t = 0; t < layer.size(); ++t) {
        if (layer[t] >= 0) {
            front.push_back(static_cast<std::int32_t>(t));
        }
    }
    for (std::size_t k = 0; k < front.size(); ++k) {
        const auto t = static_cast<std::size_t>(front[k]);
        for (const TileKey key : TileGrid<D>::ring(candidates.tiles[t].key)) {
            const auto it = row_of.find(key);
            if (it != row_of.end() && layer[static_cast<std::size_t>(it->second)] < 0) {
                layer[static_cast<std::size_t>(it->second)] = layer[t] + 1;
                front.push_back(it->second);
            }
        }
    }
}

/// Layers of the tiles that no other rank's grains can be reached from: slices across the longest axis, from 1 on.
template <int D>
void slice(const CandidateSet<D>& candidates, std::vector<int>& layer) {
    using Coordinates = typename TileGrid<D>::Coordinates;
    Coordinates low{}, high{};
    bool any = false;
    for (std::size_t t = 0; t < layer.size(); ++t) {
        if (layer[t] >= 0) {
            continue;
        }
        const auto c = TileGrid<D>::unpack(candidates.tiles[t].key);
        for (int d = 0; d < D; ++d) {
            low[d] = any ? std::min(low[d], c[d]) : c[d];
            high[d] = any ? std::max(high[d], c[d]) : c[d];
        }
        any = true;
    }
    int axis = 0;
    for (int d = 1; d < D; ++d) {
        axis = high[d] - low[d] > high[axis] - low[axis] ? d : axis;
    }
    for (std::size_t t = 0; t < layer.size(); ++t) {
        if (layer[t] < 0) {
            layer[t] = 1 + static_cast<int>(TileGrid<D>::unpack(candidates.tiles[t].key)[axis] - low[axis]);
        }
    }
}

} // namespace

template <int D>
void TileOrder<D>::build(const CandidateSet<D>& candidates) {
    std::unordered_map<TileKey, std::int32_t> row_of;
    const auto tiles = candidates.plain_tiles();
    std::vector<int> layer(tiles.size(), -1);
    bool any = false;
    for (std::size_t t = 0; t < layer.size(); ++t) {
        layer[t] = tiles[t].interface ? 0 : -1;
        any = any || tiles[t].interface;
    }
    if (any) {
        row_of.reserve(layer.size());
        for (std::size_t t = 0; t < layer.size(); ++t) {
            row_of.emplace(tiles[t].key, static_cast<std::int32_t>(t));
        }
        spread(candidates, row_of, layer);
    }
    slice(candidates, layer);
    const int last = layer.empty() ? 0 : *std::max_element(layer.begin(), layer.end());
    layers_.resize(static_cast<std::size_t>(last) + 1);
    for (auto& of_layer : layers_) {
        for (auto& of_colour : of_layer) {
            of_colour.clear();
        }
    }
    for (std::size_t t = 0; t < layer.size(); ++t) {
        layers_[static_cast<std::size_t>(layer[t])][static_cast<std::size_t>(tiles[t].colour)].push_back(
            static_cast<std::int32_t>(t));
    }
}

int sweeps_in_cache(double bytes, int n_layers, int phases_per_sweep) {
    static const long reported = sysconf(_SC_LEVEL2_CACHE_SIZE);
    const double cache = reported > 0 ? static_cast<double>(reported) : 1e6;
    const double of_sweep = bytes / n_layers * phases_per_sweep;
    constexpr double share = 0.6; // of the cache: the rest is for what comes and what goes
    constexpr int most = 16;      // beyond, nothing is gained
    return of_sweep * most < share * cache ? most : std::max(1, static_cast<int>(share * cache / of_sweep));
}

template class TileOrder<2>;

} // namespace nappe
