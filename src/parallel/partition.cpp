#include "parallel/partition.hpp"

#include "core/error.hpp"

#include <metis.h>

#include <algorithm>
#include <numeric>

namespace nappe {

namespace {

constexpr std::size_t least_tiles_per_part = 4;

std::vector<std::int32_t> cut_along_keys(const TileGraph& graph, std::int32_t n_parts) {
    std::vector<std::int32_t> part(graph.keys.size(), 0);
    const auto total = std::accumulate(graph.weight.begin(), graph.weight.end(), std::int64_t{0});
    std::int64_t before = 0;
    for (std::size_t t = 0; t < part.size(); ++t) {
        // By the middle of a tile's share of the work, so that no part is empty for rounding alone.
        const double middle = static_cast<double>(before) + 0.5 * static_cast<double>(graph.weight[t]);
        const double share = total > 0 ? middle / static_cast<double>(total)
                                       : (static_cast<double>(t) + 0.5) / static_cast<double>(part.size());
        part[t] = std::min(static_cast<std::int32_t>(share * n_parts), n_parts - 1);
        before += graph.weight[t];
    }
    return part;
}

std::vector<std::int32_t> cut_with_metis(const TileGraph& graph, std::int32_t n_parts) {
    const auto n = graph.keys.size();
    std::vector<idx_t> begin(n + 1, 0);
    for (const auto& e : graph.edges) {
        ++begin[static_cast<std::size_t>(e.a) + 1];
        ++begin[static_cast<std::size_t>(e.b) + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<idx_t> neighbour(static_cast<std::size_t>(begin[n])), edge_weight(neighbour.size());
    std::vector<idx_t> at(begin.begin(), begin.end() - 1);
    for (const auto& e : graph.edges) {
        const auto put = [&](std::int32_t from, std::int32_t to) {
            const auto slot = static_cast<std::size_t>(at[static_cast<std::size_t>(from)]++);
            neighbour[slot] = to;
            edge_weight[slot] = static_cast<idx_t>(e.weight);
        };
        put(e.a, e.b);
        put(e.b, e.a);
    }
    // METIS counts in 32 bits: scale down where the total would not fit.
    const auto total = std::accumulate(graph.weight.begin(), graph.weight.end(), std::int64_t{0});
    const std::int64_t scale = total / (std::int64_t{1} << 30) + 1;
    std::vector<idx_t> weight(n);
    std::transform(graph.weight.begin(), graph.weight.end(), weight.begin(),
                   [&](std::int64_t w) { return static_cast<idx_t>(w / scale); });

    idx_t options[METIS_NOPTIONS];
    METIS_SetDefaultOptions(options);
    options[METIS_OPTION_SEED] = 1;
    options[METIS_OPTION_UFACTOR] = 5; // parts within 0.5 % where tiles allow
    idx_t n_vertices = static_cast<idx_t>(n), n_constraints = 1, parts = n_parts, cut = 0;
    std::vector<idx_t> part(n);
    const int status =
        METIS_PartGraphRecursive(&n_vertices, &n_constraints, begin.data(), neighbour.data(), weight.data(), nullptr,
                                 edge_weight.data(), &parts, nullptr, nullptr, options, &cut, part.data());
    if (status != METIS_OK) {
        throw SystemError("METIS could not cut the tile graph (status " + std::to_string(status) + ")");
    }
    return {part.begin(), part.end()};
}

} // namespace

double imbalance(const TileGraph& graph, const std::vector<std::int32_t>& part, std::int32_t n_parts) {
    std::vector<std::int64_t> work(static_cast<std::size_t>(n_parts), 0);
    for (std::size_t t = 0; t < part.size(); ++t) {
        work[static_cast<std::size_t>(part[t])] += graph.weight[t];
    }
    const auto total = std::accumulate(work.begin(), work.end(), std::int64_t{0});
    const auto largest = *std::max_element(work.begin(), work.end());
    return total > 0 ? static_cast<double>(largest) * n_parts / static_cast<double>(total) : 1.0;
}

std::vector<std::int32_t> partition(const TileGraph& graph, std::int32_t n_parts) {
    if (n_parts == 1 || graph.keys.empty()) {
        return std::vector<std::int32_t>(graph.keys.size(), 0);
    }
    auto along = cut_along_keys(graph, n_parts);
    const bool idle = std::all_of(graph.weight.begin(), graph.weight.end(), [](std::int64_t w) { return w == 0; });
    if (idle || graph.keys.size() < least_tiles_per_part * static_cast<std::size_t>(n_parts)) {
        return along;
    }
    auto part = cut_with_metis(graph, n_parts);
    // A part left empty or a badly uneven cut is METIS failing on an odd graph, not a choice: the plain cut stands in.
    return imbalance(graph, part, n_parts) <= imbalance(graph, along, n_parts) + 0.05 ? part : along;
}

} // namespace nappe
