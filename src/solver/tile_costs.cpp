#include "solver/tile_costs.hpp"

#include <algorithm>
#include <cmath>

namespace nappe {

template <int D>
void TileCosts<D>::relist(const CandidateSet<D>& candidates) {
    const auto before = std::move(costs_);
    const auto tiles = candidates.plain_tiles();
    costs_.assign(tiles.size(), {});
    auto old = before.begin();
    for (std::size_t t = 0; t < costs_.size(); ++t) {
        costs_[t].key = tiles[t].key;
        while (old != before.end() && old->key < costs_[t].key) {
            ++old;
        }
        if (old != before.end() && old->key == costs_[t].key) {
            costs_[t] = *old;
        }
    }
}

template <int D>
void TileCosts<D>::add(const ContactsOf<D>& contacts, int sweeps, const std::vector<std::int32_t>& tile_sweeps,
                       const std::vector<double>& tile_seconds) {
    for (std::size_t t = 0; t < costs_.size(); ++t) {
        const auto n = contacts.n_active(t);
        costs_[t].relaxations += n * (tile_sweeps.empty() ? sweeps : tile_sweeps[t]);
        if (n > 0 && !tile_seconds.empty()) {
            const double of_one = tile_seconds[t] / static_cast<double>(n);
            costs_[t].quickest = of_one < costs_[t].quickest ? of_one : costs_[t].quickest;
        }
    }
}

template <int D>
std::vector<TileWork> TileCosts<D>::by_work() const {
    std::vector<TileWork> work;
    for (const auto& cost : costs_) {
        work.push_back({cost.key, cost.relaxations});
    }
    return work;
}

template <int D>
std::vector<TileWork> TileCosts<D>::by_time(double seconds) const {
    const auto share = [](const Cost& cost) {
        return cost.relaxations > 0 ? static_cast<double>(cost.relaxations) * cost.quickest : 0.0;
    };
    double sum = 0;
    for (const auto& cost : costs_) {
        sum += share(cost);
    }
    std::vector<TileWork> work;
    for (const auto& cost : costs_) {
        work.push_back({cost.key, sum > 0 ? std::llround(1e9 * seconds * share(cost) / sum) : 0});
    }
    return work;
}

template <int D>
void TileCosts<D>::clear() {
    for (auto& cost : costs_) {
        cost = {cost.key};
    }
}

template class TileCosts<2>;

} // namespace nappe
