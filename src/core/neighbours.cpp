#include "core/neighbours.hpp"

#include "core/cell_index.hpp"
#include "core/large_grains.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

namespace nappe {

namespace {

/// One tile's contacts in canonical order: lo by id (rows are sorted so), then partners by key.
template <int D>
class TileSearch {
public:
    TileSearch(const State<D>& state, const TileGrid<D>& grid, const Walls<D>& walls, const CellIndex<D>& cells)
        : state_(state), grid_(grid), walls_(walls), cells_(cells) {}

    void run(std::size_t slot) {
        a.clear();
        b.clear();
        const auto ring = cells_.ring(slot);
        const Vec<D> corner = grid_.corner(cells_.key(slot));
        double widest = 0;
        for (const int s : ring) {
            if (s >= 0) {
                widest = std::max(widest, cells_.slow_extent(static_cast<std::size_t>(s)));
            }
        }
        near_features(slot);
        for (LocalId i = cells_.begin(slot); i < cells_.end(slot); ++i) {
            if (state_.is_large(i)) {
                continue;
            }
            const double reach = state_.reach(i);
            find_partners(i, corner, ring, reach, reach + widest);
            for (std::size_t k = 0; k < found_; ++k) {
                a.push_back(i);
                b.push_back(partners_[k].second);
            }
            add_walls(i, reach);
        }
    }

    /// The contacts of large grains, whatever tile they are in.
    void run_large(const std::vector<LocalId>& large) {
        struct Pair {
            GlobalId lo, hi;
            LocalId a, b;
        };
        std::vector<Pair> pairs;
        features_.resize(static_cast<std::size_t>(walls_.n_features()));
        std::iota(features_.begin(), features_.end(), 0);
        for (const LocalId i : large) {
            const double reach = state_.reach(i);
            for (LocalId j = 0; j < state_.n_held(); ++j) {
                if (j == i || (state_.is_large(j) && state_.id[j] < state_.id[i]) ||
                    !may_touch<D>(state_.x_ref[j], state_.reach(j), state_.x_ref[i], reach)) {
                    continue;
                }
                const LocalId lo = state_.id[j] < state_.id[i] ? j : i, hi = lo == j ? i : j;
                pairs.push_back({state_.id[lo], state_.id[hi], lo, hi});
            }
            a.clear();
            b.clear();
            add_walls(i, reach);
            for (const LocalId wall : b) {
                pairs.push_back({state_.id[i], partner_key(state_, wall), i, wall});
            }
        }
        std::sort(pairs.begin(), pairs.end(),
                  [](const Pair& p, const Pair& q) { return p.lo != q.lo ? p.lo < q.lo : p.hi < q.hi; });
        a.clear();
        b.clear();
        for (const auto& pair : pairs) {
            a.push_back(pair.a);
            b.push_back(pair.b);
        }
    }

    std::vector<LocalId> a, b;

private:
    /// Held grains of higher id whose surfaces are near enough, by id. What is rejected is overwritten, not branched
    /// around: which half of the neighbours counts is a toss of a coin.
    void find_partners(LocalId i, const Vec<D>& corner, const typename CellIndex<D>::Ring& ring, double reach,
                       double range) {
        const Vec<D> x = state_.x_ref[i];
        const GlobalId id = state_.id[i];
        std::size_t n = 0;
        cells_.for_each_near(corner, ring, x, range, [&](const Spot<D>* begin, const Spot<D>* end) {
            if (partners_.size() < n + static_cast<std::size_t>(end - begin)) {
                partners_.resize(2 * (n + static_cast<std::size_t>(end - begin)));
            }
            for (const auto* spot = begin; spot != end; ++spot) {
                const double most = reach + spot->extent;
                double squared = 0;
                for (int d = 0; d < D; ++d) {
                    squared += (spot->x[d] - x[d]) * (spot->x[d] - x[d]);
                }
                partners_[n] = {spot->id, spot->row};
                n += static_cast<std::size_t>(squared <= most * most) & static_cast<std::size_t>(spot->id > id);
            }
        });
        found_ = n;
        for (std::size_t k = 1; k < n; ++k) { // a handful: by insertion
            const auto partner = partners_[k];
            std::size_t at = k;
            for (; at > 0 && partner < partners_[at - 1]; --at) {
                partners_[at] = partners_[at - 1];
            }
            partners_[at] = partner;
        }
    }

    void near_features(std::size_t slot) {
        features_.clear();
        const TileKey key = cells_.key(slot);
        const Vec<D> middle = grid_.corner(key) + Vec<D>::Constant(0.5 * grid_.side());
        const double half_diagonal = 0.5 * grid_.side() * std::sqrt(static_cast<double>(D)) * (1 + 1e-9);
        for (int f = 0; f < walls_.n_features(); ++f) {
            const double margin = wall_reach(f);
            if (walls_.distance_ref(f, middle) <= half_diagonal + cells_.extent(slot) + margin) {
                features_.push_back(f);
            }
        }
    }

    double wall_reach(int f) const {
        return walls_.margin[static_cast<std::size_t>(walls_.feature(2 * f).wall)] + state_.attraction;
    }

    void add_walls(LocalId i, double reach) {
        for (const int f : features_) {
            const double margin = wall_reach(f);
            if (walls_.distance_ref(f, state_.x_ref[i]) <= reach + margin) {
                a.push_back(i);
                b.push_back(state_.n_held() + walls_.side_of(f, state_.x_ref[i]));
            }
        }
    }

    const State<D>& state_;
    const TileGrid<D>& grid_;
    const Walls<D>& walls_;
    const CellIndex<D>& cells_;
    std::vector<int> features_;
    std::vector<std::pair<GlobalId, LocalId>> partners_; ///< the first found_ are those of the grain asked last
    std::size_t found_ = 0;
};

} // namespace

void colour_contacts(std::span<const LocalId> a, std::span<const LocalId> b, LocalId n_grains,
                     std::vector<std::uint64_t>& used, std::vector<std::int32_t>& colour) {
    const std::size_t n = a.size();
    used.resize(static_cast<std::size_t>(n_grains), 0);
    colour.assign(n, -1);
    std::size_t left = n;
    for (std::int32_t base = 0; left > 0; base += 64) { // a grain with more than 64 contacts needs another round
        for (std::size_t c = 0; c < n; ++c) {
            if (colour[c] >= 0) {
                continue;
            }
            std::uint64_t& taken_a = used[static_cast<std::size_t>(a[c])];
            std::uint64_t* taken_b = b[c] < n_grains ? &used[static_cast<std::size_t>(b[c])] : nullptr;
            const std::uint64_t taken = taken_a | (taken_b != nullptr ? *taken_b : 0);
            if (taken == ~std::uint64_t{0}) {
                continue;
            }
            const int first = std::countr_one(taken);
            colour[c] = base + first;
            taken_a |= std::uint64_t{1} << first;
            if (taken_b != nullptr) {
                *taken_b |= std::uint64_t{1} << first;
            }
            --left;
        }
        for (std::size_t c = 0; c < n; ++c) {
            used[static_cast<std::size_t>(a[c])] = 0;
            if (b[c] < n_grains) {
                used[static_cast<std::size_t>(b[c])] = 0;
            }
        }
    }
}

namespace {

/// Puts one tile's contacts behind those of the tiles before it, in the order of CandidateSet.
template <int D>
class TileWriter {
public:
    TileWriter(const State<D>& state, CandidateSet<D>& set) : state_(state), set_(set) {}

    /// @param impulse of (row of lo, id of lo, name of hi)
    template <class F>
    void put(Tile tile, std::span<const LocalId> a, std::span<const LocalId> b, F&& impulse) {
        const std::size_t n = a.size();
        colour_contacts(a, b, state_.n_held(), used_, colour_);
        const std::int32_t n_classes = n == 0 ? 0 : 1 + *std::max_element(colour_.begin(), colour_.end());
        tile.candidates_begin = set_.size();
        tile.candidates_end = set_.size() + static_cast<std::int32_t>(n);
        tile.classes_begin = static_cast<std::int32_t>(set_.class_begin.size());
        tile.classes_end = tile.classes_begin + n_classes;

        n_in_class_.assign(static_cast<std::size_t>(n_classes), 0);
        for (const std::int32_t k : colour_) {
            ++n_in_class_[static_cast<std::size_t>(k)];
        }
        std::int32_t next = tile.candidates_begin;
        at_.clear();
        for (const std::int32_t count : n_in_class_) {
            set_.class_begin.push_back(next);
            at_.push_back(next);
            next += count;
        }
        set_.a.resize(static_cast<std::size_t>(tile.candidates_end));
        set_.b.resize(set_.a.size());
        set_.r_n.resize(set_.a.size());
        set_.r_t.resize(state_.carries.friction ? set_.a.size() : 0);
        for (std::size_t c = 0; c < n; ++c) {
            const auto to = static_cast<std::size_t>(at_[static_cast<std::size_t>(colour_[c])]++);
            set_.a[to] = a[c];
            set_.b[to] = b[c];
            set_.set_impulse(to, impulse(a[c], state_.id[a[c]], partner_key(state_, b[c])));
        }
        set_.tiles.push_back(tile);
    }

private:
    const State<D>& state_;
    CandidateSet<D>& set_;
    std::vector<std::int32_t> n_in_class_, at_, colour_;
    std::vector<std::uint64_t> used_;
};

} // namespace

template <int D>
void find_candidates(const State<D>& state, const TileGrid<D>& grid, const Walls<D>& walls,
                     const ContactMemory<D>& memory, CandidateSet<D>& set) {
    const CellIndex<D> cells(state, grid);
    TileSearch<D> search(state, grid, walls, cells);
    set.clear();
    TileWriter<D> writer(state, set);
    for (std::size_t slot = 0; slot < cells.n_own_tiles(); ++slot) {
        search.run(slot);
        Tile tile;
        tile.key = cells.key(slot);
        tile.colour = TileGrid<D>::colour(tile.key);
        tile.grains_begin = cells.begin(slot);
        tile.grains_end = cells.end(slot);
        writer.put(tile, search.a, search.b,
                   [&](LocalId row, GlobalId lo, GlobalId hi) { return memory.find(row, lo, hi); });
    }
    const auto large = large_rows(state);
    if (!large.empty()) {
        search.run_large(large);
        Tile tile;
        tile.large = true;
        set.counts_large = large.front() < state.n_own;
        writer.put(tile, search.a, search.b,
                   [&](LocalId, GlobalId lo, GlobalId hi) { return memory.find_of_large(lo, hi); });
    }
}

template void find_candidates(const State<2>&, const TileGrid<2>&, const Walls<2>&, const ContactMemory<2>&,
                              CandidateSet<2>&);

} // namespace nappe
