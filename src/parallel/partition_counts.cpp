#include "parallel/partition_counts.hpp"

#include "parallel/halo.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace nappe {

namespace {

/// Parts that hold a grain, for grains that more than one part holds; the others have an empty range.
struct SharedGrains {
    std::vector<std::int64_t> begin;
    std::vector<std::int32_t> holders;

    std::span<const std::int32_t> of(LocalId i) const {
        const auto at = static_cast<std::size_t>(i);
        return {holders.data() + begin[at], holders.data() + begin[at + 1]};
    }
};

template <int D>
SharedGrains find_shared(const State<D>& state, const TileGrid<D>& grid, const CandidateSet<D>& candidates,
                         const TileDirectory& directory) {
    double range_max = 0;
    for (std::size_t i = 0; i < state.radius.size(); ++i) {
        range_max = std::max(range_max, state.reach(static_cast<LocalId>(i)));
    }
    SharedGrains shared;
    shared.begin.assign(static_cast<std::size_t>(state.n_held()) + 1, 0);
    std::vector<int> others;
    for (const auto& tile : candidates.plain_tiles()) { // in the order of rows
        const auto owner = directory.owner(tile.key);
        Holders<D> holders(grid, directory, owner);
        for (auto i = static_cast<std::size_t>(tile.grains_begin); i < static_cast<std::size_t>(tile.grains_end); ++i) {
            holders.find(tile.key, state.x_ref[i], state.reach(static_cast<LocalId>(i)) + range_max, others);
            if (!others.empty()) {
                shared.holders.push_back(owner);
                shared.holders.insert(shared.holders.end(), others.begin(), others.end());
            }
            shared.begin[i + 1] = static_cast<std::int64_t>(shared.holders.size());
        }
    }
    return shared;
}

} // namespace

template <int D>
std::int64_t PartCounts<D>::relaxations() const {
    return std::accumulate(interface.begin(), interface.end(), std::int64_t{0}) +
           std::accumulate(interior.begin(), interior.end(), std::int64_t{0});
}

void merge_messages(std::vector<MessageCount>& messages) {
    const auto name = [](const MessageCount& m) { return std::tuple(m.from, m.colour, m.to); };
    std::sort(messages.begin(), messages.end(), [&](const auto& p, const auto& q) { return name(p) < name(q); });
    std::size_t n = 0;
    for (const auto& m : messages) {
        if (n > 0 && name(messages[n - 1]) == name(m)) {
            messages[n - 1].grains += m.grains;
        } else {
            messages[n++] = m;
        }
    }
    messages.resize(n);
}

template <int D>
PartitionCounts<D> count_partition(const State<D>& state, const TileGrid<D>& grid, const CandidateSet<D>& candidates,
                                   std::span<const std::int64_t> relaxations, const TileDirectory& directory,
                                   std::int32_t n_parts) {
    const auto shared = find_shared(state, grid, candidates, directory);
    PartitionCounts<D> counts;
    counts.parts.resize(static_cast<std::size_t>(n_parts));
    std::vector<std::int32_t> touched_by(static_cast<std::size_t>(state.n_held()), -1);
    std::vector<MessageCount> of_tile;
    for (std::size_t t = 0; t < candidates.plain_tiles().size(); ++t) {
        const auto& tile = candidates.plain_tiles()[t];
        const auto owner = directory.owner(tile.key);
        of_tile.clear();
        const auto touch = [&](LocalId i) {
            if (i >= state.n_held() || touched_by[static_cast<std::size_t>(i)] == static_cast<std::int32_t>(t)) {
                return;
            }
            touched_by[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(t);
            for (const auto to : shared.of(i)) {
                if (to == owner) {
                    continue;
                }
                auto it = std::find_if(of_tile.begin(), of_tile.end(), [&](const auto& m) { return m.to == to; });
                it = it == of_tile.end() ? of_tile.insert(it, {owner, tile.colour, to, 0}) : it;
                ++it->grains;
            }
        };
        for (auto c = static_cast<std::size_t>(tile.candidates_begin);
             c < static_cast<std::size_t>(tile.candidates_end); ++c) {
            touch(candidates.a[c]);
            touch(candidates.b[c]);
        }
        auto& part = counts.parts[static_cast<std::size_t>(owner)];
        (of_tile.empty() ? part.interior : part.interface)[static_cast<std::size_t>(tile.colour)] += relaxations[t];
        part.tiles += 1;
        part.grains += tile.grains_end - tile.grains_begin;
        counts.messages.insert(counts.messages.end(), of_tile.begin(), of_tile.end());
    }
    merge_messages(counts.messages);
    return counts;
}

template struct PartCounts<2>;
template PartitionCounts<2> count_partition(const State<2>&, const TileGrid<2>&, const CandidateSet<2>&,
                                            std::span<const std::int64_t>, const TileDirectory&, std::int32_t);

} // namespace nappe
