#pragma once
// Which rank owns which tile; the same on every rank.

#include "core/snapshot.hpp"
#include "core/tile_grid.hpp"

#include <algorithm>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace nappe {

class TileDirectory {
public:
    /// Rank that owns a tile, or -1 for a tile in which no grain has been yet.
    std::int32_t owner(TileKey key) const {
        const auto it = owner_.find(key);
        return it == owner_.end() ? -1 : it->second;
    }

    /// Replaces everything. Arrays of equal length.
    void assign(const std::vector<TileKey>& keys, const std::vector<std::int32_t>& owners) {
        owner_.clear();
        owner_.reserve(keys.size());
        for (std::size_t t = 0; t < keys.size(); ++t) {
            owner_.emplace(keys[t], owners[t]);
        }
    }

    /// A new tile; the first claim counts.
    void add(TileKey key, std::int32_t rank) { owner_.try_emplace(key, rank); }

    /// All of it, by key.
    std::vector<TileOwner> owners() const {
        std::vector<TileOwner> all;
        for (const auto& [key, rank] : owner_) {
            all.push_back({key, rank});
        }
        std::sort(all.begin(), all.end(), [](const TileOwner& p, const TileOwner& q) { return p.key < q.key; });
        return all;
    }

    std::size_t size() const { return owner_.size(); }

private:
    std::unordered_map<TileKey, std::int32_t> owner_;
};

} // namespace nappe
