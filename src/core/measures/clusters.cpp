#include "core/measures/clusters.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

namespace nappe {

Clusters clusters(std::int64_t n, std::span<const BondedPair> bonds) {
    std::vector<GlobalId> above(static_cast<std::size_t>(n)); // towards the lowest id of the block
    std::iota(above.begin(), above.end(), 0);
    const auto lowest = [&](GlobalId i) {
        while (above[static_cast<std::size_t>(i)] != i) {
            auto& up = above[static_cast<std::size_t>(i)];
            i = up = above[static_cast<std::size_t>(up)]; // halves the way for those who come after
        }
        return i;
    };
    for (const auto& [i, j] : bonds) {
        const GlobalId a = lowest(i), b = lowest(j);
        above[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
    std::vector<std::int64_t> size(above.size(), 0);
    for (GlobalId i = 0; i < n; ++i) {
        ++size[static_cast<std::size_t>(lowest(i))];
    }
    Clusters found;
    for (const auto grains : size) {
        found.largest = std::max(found.largest, grains);
        found.detached += grains > 1 ? 1 : 0;
        found.detached_grains += grains > 1 ? grains : 0;
        found.single += grains == 1 ? 1 : 0;
    }
    if (found.largest > 1) {
        --found.detached;
        found.detached_grains -= found.largest;
    }
    return found;
}

} // namespace nappe
