#pragma once
// The candidates: pairs that may touch before the next rebuild, by tile, frozen until then.

#include "core/state.hpp"
#include "core/tile_grid.hpp"
#include "core/walls.hpp"

#include <span>
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
    bool large = false;                              ///< no tile, but the contacts of all large grains; it comes last
};

/// Candidates in the order of the sweep: by tile; in a tile by colour class; in a class by key (lo id, hi key). `a` is
/// always an owned grain, the one with the lower GlobalId, whose tile the contact belongs to; `b` is a held grain or a
/// wall body. No two contacts of a class share a grain; wall bodies do not count, they are never written.
/// The contacts of large grains follow those of the tiles, as if of one more; there `a` need not be owned.
template <int D>
struct CandidateSet {
    std::vector<Tile> tiles; ///< in the order of keys, then that of large grains if one is held
    std::vector<LocalId> a, b;
    std::vector<double> r_n;                    ///< of the last step [N s]
    std::vector<std::array<double, D - 1>> r_t; ///< likewise; empty without friction
    std::vector<Bond> bond;                     ///< at the start of the step; empty unless cohesion acts
    /// First candidate of every class; a class ends where the next or the tile does.
    std::vector<std::int32_t> class_begin;

    /// Whether it is this rank that counts the contacts of large grains, which several have. Sums over contacts go over
    /// `counted_tiles`, or over contacts whose `a` is owned.
    bool counts_large = false;

    std::int32_t size() const { return static_cast<std::int32_t>(a.size()); }

    bool has_large() const { return !tiles.empty() && tiles.back().large; }
    std::span<const Tile> plain_tiles() const { return std::span(tiles).first(tiles.size() - (has_large() ? 1 : 0)); }
    std::span<const Tile> counted_tiles() const {
        return std::span(tiles).first(tiles.size() - (has_large() && !counts_large ? 1 : 0));
    }

    /// Empties it and keeps its memory.
    void clear() {
        tiles.clear();
        counts_large = false;
        a.clear();
        b.clear();
        r_n.clear();
        r_t.clear();
        bond.clear();
        class_begin.clear();
    }

    std::int32_t class_end(const Tile& tile, std::int32_t k) const {
        return k + 1 < tile.classes_end ? class_begin[static_cast<std::size_t>(k + 1)] : tile.candidates_end;
    }

    Impulse<D> impulse(std::size_t c) const { return {r_n[c], r_t.empty() ? std::array<double, D - 1>{} : r_t[c]}; }
    void set_impulse(std::size_t c, const Impulse<D>& r) {
        r_n[c] = r.n;
        if (!r_t.empty()) {
            r_t[c] = r.t;
        }
    }

    /// Calls f(name, array) for every array over candidates.
    template <class F>
    void for_each_array(F&& f) const {
        f("a", a);
        f("b", b);
        f("r_n", r_n);
        f("r_t", r_t);
        f("bond", bond);
    }
};

/// Impulses that survive a rebuild. By row of the lower grain, as it was, while rows move on a rank; by name where
/// grains change ranks or come from a sample.
template <int D>
class ContactMemory {
public:
    ContactMemory() = default;
    /// By name, rows in any order.
    explicit ContactMemory(std::vector<ContactRow<D>> rows) { add(std::move(rows)); }

    /// Local. Forgets all and takes the impulses of these candidates, by present rows.
    void keep(const State<D>& state, const CandidateSet<D>& candidates);

    /// Local. Of what is held, that of owned grains by present rows; the rest is forgotten.
    void rekey(const State<D>& state);

    /// Local. Own row i was row from[i] until now; -1: new here, its impulses are held by name.
    void rows_moved(std::vector<LocalId> from) { from_ = std::move(from); }

    /// Local. More impulses by name, in any order.
    void add(std::vector<ContactRow<D>> rows);

    /// Local. Those of large grains, by name: all ranks know them.
    void set_of_large(std::vector<ContactRow<D>> rows);
    Impulse<D> find_of_large(GlobalId lo, GlobalId hi) const; ///< zero if the pair was not touching

    /// Zero if the pair was not touching. @param row of the grain `lo`
    Impulse<D> find(LocalId row, GlobalId lo, GlobalId hi) const;

    /// Calls f(hi, impulse) for what is held of a grain.
    template <class F>
    void for_each(LocalId row, GlobalId lo, F&& f) const {
        const LocalId was = from_.empty() ? row : from_[static_cast<std::size_t>(row)];
        if (was >= 0 && static_cast<std::size_t>(was) + 1 < begin_.size()) {
            for (auto k = begin_[static_cast<std::size_t>(was)]; k < begin_[static_cast<std::size_t>(was) + 1]; ++k) {
                f(partners_[static_cast<std::size_t>(k)].hi, partners_[static_cast<std::size_t>(k)].r);
            }
            return;
        }
        for (auto k = first_named(lo); k < named_.size() && named_[k].lo == lo; ++k) {
            f(named_[k].hi, Impulse<D>{named_[k].r_n, named_[k].r_t});
        }
    }

private:
    struct Partner {
        GlobalId hi = 0;
        Impulse<D> r;
    };

    std::size_t first_named(GlobalId lo) const;

    std::vector<std::int32_t> begin_; ///< partners of old rows
    std::vector<Partner> partners_;
    std::vector<LocalId> from_;           ///< empty: rows are as they were
    std::vector<ContactRow<D>> named_;    ///< sorted by (lo, hi)
    std::vector<ContactRow<D>> of_large_; ///< likewise
};

/// Name of a contact's partner that frames, samples and canonical order use.
template <int D>
GlobalId partner_key(const State<D>& state, LocalId b) {
    return b < state.n_held() ? state.id[static_cast<std::size_t>(b)] : wall_key + (b - state.n_held());
}

/// Local. The impulses of all candidates that have one and whose lower grain is owned, in candidate order.
template <int D>
std::vector<ContactRow<D>> impulse_rows(const State<D>& state, const CandidateSet<D>& candidates);

} // namespace nappe
