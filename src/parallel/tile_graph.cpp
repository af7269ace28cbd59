#include "parallel/tile_graph.hpp"

#include <algorithm>
#include <utility>

namespace nappe {

template <int D>
TileGraph tile_graph(std::vector<TileWork> work, std::vector<TileLink> links) {
    std::sort(work.begin(), work.end(), [](const auto& p, const auto& q) { return p.key < q.key; });
    TileGraph graph;
    for (const auto& w : work) {
        if (graph.keys.empty() || graph.keys.back() != w.key) {
            graph.keys.push_back(w.key);
            graph.weight.push_back(0);
        }
        graph.weight.back() += w.weight;
    }
    for (auto& link : links) {
        if (link.b < link.a) {
            std::swap(link.a, link.b);
        }
    }
    const auto ends = [](const TileLink& link) { return std::pair(link.a, link.b); };
    std::sort(links.begin(), links.end(), [&](const auto& p, const auto& q) { return ends(p) < ends(q); });

    auto link = links.begin(); // pairs of tiles come in the order of links: one pass over both
    for (std::size_t t = 0; t < graph.keys.size(); ++t) {
        const TileKey key = graph.keys[t];
        for (const TileKey other : TileGrid<D>::ring(key)) {
            if (other <= key) {
                continue;
            }
            const auto from = graph.keys.begin() + static_cast<std::ptrdiff_t>(t);
            const auto it = std::lower_bound(from, graph.keys.end(), other);
            if (it == graph.keys.end() || *it != other) {
                continue;
            }
            const auto u = it - graph.keys.begin();
            std::int64_t w = 1;
            if (links.empty()) {
                w += std::min(graph.weight[t], graph.weight[static_cast<std::size_t>(u)]) / 8;
            }
            while (link != links.end() && ends(*link) < std::pair(key, other)) {
                ++link;
            }
            for (; link != links.end() && ends(*link) == std::pair(key, other); ++link) {
                w += link->contacts;
            }
            graph.edges.push_back({static_cast<std::int32_t>(t), static_cast<std::int32_t>(u), w});
        }
    }
    return graph;
}

template <int D>
std::vector<TileLink> tile_links(const State<D>& state, const TileGrid<D>& grid, const CandidateSet<D>& candidates) {
    std::vector<TileLink> links;
    for (const auto& tile : candidates.plain_tiles()) {
        const auto ring = TileGrid<D>::ring(tile.key);
        std::array<std::int64_t, TileGrid<D>::n_ring> shared{};
        for (auto c = tile.candidates_begin; c < tile.candidates_end; ++c) {
            const LocalId b = candidates.b[static_cast<std::size_t>(c)];
            if (b < state.n_held()) {
                const TileKey other = grid.key(state.x_ref[static_cast<std::size_t>(b)]);
                const auto at = std::find(ring.begin(), ring.end(), other);
                ++shared[static_cast<std::size_t>(at - ring.begin())];
            }
        }
        for (std::size_t k = 0; k < ring.size(); ++k) {
            if (ring[k] != tile.key && shared[k] > 0) {
                links.push_back({tile.key, ring[k], shared[k]});
            }
        }
    }
    return links;
}

template TileGraph tile_graph<2>(std::vector<TileWork>, std::vector<TileLink>);
template std::vector<TileLink> tile_links(const State<2>&, const TileGrid<2>&, const CandidateSet<2>&);

} // namespace nappe
