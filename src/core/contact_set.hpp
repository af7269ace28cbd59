#pragma once
// The candidates: pairs that may touch before the next rebuild, by tile, frozen until then.

#include "core/state.hpp"
#include "core/tile_grid.hpp"
#include "core/walls.hpp"

#include <unordered_map>
#include <vector>

namespace nappe {

/// Normal and tangential impulse of a contact [N s]; what warm start carries from step to step.
template <int D>
struct Impulse {
    double n = 0;
    std::array<double, D - 1> t{};
};

/// A tile this rank owns. Ranges are half-open.
struct Tile {
    TileKey key = 0;
    int colour = 0;
    LocalId grains_begin = 0, grains_end = 0;
    std::int32_t candidates_begin = 0, candidates_end = 0;
    std::int32_t classes_begin = 0, classes_end = 0; ///< into CandidateSet::class_begin
    bool interface = false;                          ///< touches a grain that another rank holds
};

/// Candidates in the order of the sweep: by tile; in a tile by colour class; in a class by key (lo id, hi key). `a` is
/// always an owned grain, the one with the lower GlobalId, whose tile the contact belongs to; `b` is a held grain or a
/// wall body. No two contacts of a class share a grain; wall bodies do not count, they are never written.
template <int D>
struct CandidateSet {
    std::vector<Tile> tiles; ///< in the order of keys
    std::vector<LocalId> a, b;
    std::vector<Impulse<D>> r; ///< of the last step
    /// First candidate of every class; a class ends where the next or the tile does.
    std::vector<std::int32_t> class_begin;

    std::int32_t size() const { return static_cast<std::int32_t>(a.size()); }

    std::int32_t class_end(const Tile& tile, std::int32_t k) const {
        return k + 1 < tile.classes_end ? class_begin[static_cast<std::size_t>(k + 1)] : tile.candidates_end;
    }

    /// Bytes of one candidate, a figure of the code.
    static constexpr std::size_t bytes_per_candidate() { return 2 * sizeof(LocalId) + sizeof(Impulse<D>); }
};

/// Impulses by name, sorted by (lo, hi): what survives a rebuild.
template <int D>
class ContactMemory {
public:
    ContactMemory() = default;
    explicit ContactMemory(std::vector<ContactRow<D>> rows);

    /// Zero if the pair was not touching.
    Impulse<D> find(GlobalId lo, GlobalId hi) const;

    const std::vector<ContactRow<D>>& rows() const { return rows_; }

private:
    std::vector<ContactRow<D>> rows_;
    std::unordered_map<GlobalId, std::int32_t> first_; ///< row where a grain's contacts begin
};

/// Name of a contact's partner that frames, samples and canonical order use.
template <int D>
GlobalId partner_key(const State<D>& state, LocalId b) {
    return b < state.n_held() ? state.id[static_cast<std::size_t>(b)] : wall_key + (b - state.n_held());
}

/// Local. The impulses of all candidates that have one, in candidate order.
template <int D>
std::vector<ContactRow<D>> impulse_rows(const State<D>& state, const CandidateSet<D>& candidates);

} // namespace nappe
