#include "core/neighbours.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <bit>
#include <unordered_map>

namespace nappe {

namespace {

/// What the search asks of a grain.
template <int D>
struct Spot {
    std::array<double, D> x;
    double extent; ///< State::reach [m]
    GlobalId id;
    LocalId row;
};

/// Grains of all held tiles, each tile cut into k^D cells about as wide as two grains, so that a search looks at few of
/// them. The few that have long ways to go are kept apart, or every search around them would have to look as far.
template <int D>
class CellIndex {
public:
    using Ring = std::array<int, TileGrid<D>::n_ring>;

    CellIndex(const State<D>& state, const TileGrid<D>& grid) : state_(state), grid_(grid) {
        double widest = 0;
        for (LocalId i = 0; i < state.n_held(); ++i) {
            widest = std::max(widest, state.radius[i]);
        }
        // Twice the largest radius: a search of a slow grain covers 3 x 3 cells.
        slow_ = 1.35 * widest;
        k_ = widest > 0 ? std::max(1, static_cast<int>(grid.side() / (2.05 * widest))) : 1;
        n_cells_ = 1;
        for (int d = 0; d < D; ++d) {
            n_cells_ *= k_;
        }
        spots_.resize(static_cast<std::size_t>(state.n_held()));
        collect(0, state.n_own);
        n_own_tiles_ = keys_.size();
        collect(state.n_own, state.n_held());
    }

    std::size_t n_own_tiles() const { return n_own_tiles_; }
    TileKey key(std::size_t slot) const { return keys_[slot]; }
    LocalId begin(std::size_t slot) const { return begin_[slot]; }
    LocalId end(std::size_t slot) const { return end_[slot]; }

    /// Slots of a tile and its neighbours; -1 where nothing is held.
    Ring ring(std::size_t slot) const {
        Ring slots;
        const auto keys = TileGrid<D>::ring(keys_[slot]);
        for (std::size_t i = 0; i < keys.size(); ++i) {
            const auto it = slot_of_.find(keys[i]);
            slots[i] = it == slot_of_.end() ? -1 : it->second;
        }
        return slots;
    }

    /// Largest reach among the slow grains of a tile [m].
    double slow_extent(std::size_t slot) const { return extent_[slot] < slow_ ? extent_[slot] : slow_; }

    /// Largest reach among the grains of a tile [m].
    double extent(std::size_t slot) const { return extent_[slot]; }

    /// Calls f(begin, end) for runs of held grains in tiles of `ring` around the tile with this corner: the slow ones in cells within
    /// `range` of x, and all that are not slow.
    template <class F>
    void for_each_near(const Vec<D>& corner, const Ring& ring, const Vec<D>& x, double range, F&& f) const {
        for (const int slot : ring) {
            if (slot >= 0) {
                const auto at = static_cast<std::size_t>(slot);
                f(fast_.data() + fast_begin_[at], fast_.data() + fast_begin_[at + 1]);
            }
        }
        static_assert(D == 2, "the loops below are the plane's");
        const double per_cell = static_cast<double>(k_) / grid_.side();
        const auto cell = [&](double coordinate) {
            const int c = static_cast<int>(std::floor(coordinate * per_cell));
            return std::clamp(c, -k_, 2 * k_ - 1);
        };
        // A relative widening well above round-off, so that a cell's edge can hide no pair.
        const double r = range * (1 + 1e-9) + 1e-12 * grid_.side();
        const int x0 = cell(x[0] - corner[0] - r), x1 = cell(x[0] - corner[0] + r);
        const int y0 = cell(x[1] - corner[1] - r), y1 = cell(x[1] - corner[1] + r);
        for (int cx = x0; cx <= x1; ++cx) {
            const int tx = cx < 0 ? 0 : (cx < k_ ? 1 : 2);
            for (int ty = y0 < 0 ? 0 : (y0 < k_ ? 1 : 2); ty < 3 && (ty - 1) * k_ <= y1; ++ty) {
                const int other = ring[static_cast<std::size_t>(3 * tx + ty)];
                if (other < 0) {
                    continue;
                }
                // The cells of a column lie one behind the other.
                const int column = (cx - (tx - 1) * k_) * k_, bottom = (ty - 1) * k_;
                const int first = std::max(y0 - bottom, 0), last = std::min(y1 - bottom, k_ - 1);
                const std::int32_t* begin = &cell_begin_[static_cast<std::size_t>(other) * (n_cells_ + 1)] + column;
                f(spots_.data() + begin[first], spots_.data() + begin[last + 1]);
            }
        }
    }

private:
    void collect(LocalId from, LocalId to) {
        TileKey key = from < to ? grid_.key(state_.x_ref[from]) : 0;
        for (LocalId i = from; i < to;) {
            LocalId j = i;
            double extent = 0;
            TileKey next = key;
            NAPPE_ASSERT(!slot_of_.contains(key), "rows are not sorted by tile at row " + std::to_string(i));
            while (next == key) {
                NAPPE_ASSERT(j == i || state_.id[j - 1] < state_.id[j],
                             "ids fall within a tile at row " + std::to_string(j));
                extent = std::max(extent, state_.reach(j));
                if (++j == to) {
                    break;
                }
                next = grid_.key(state_.x_ref[j]);
            }
            slot_of_.emplace(key, static_cast<int>(keys_.size()));
            keys_.push_back(key);
            begin_.push_back(i);
            end_.push_back(j);
            extent_.push_back(extent);
            sort_into_cells(key, i, j);
            i = j;
            key = next;
        }
    }

    void sort_into_cells(TileKey key, LocalId from, LocalId to) {
        const Vec<D> corner = grid_.corner(key);
        const double per_cell = static_cast<double>(k_) / grid_.side();
        const std::size_t base = cell_begin_.size();
        cell_begin_.resize(base + n_cells_ + 1, 0);
        cell_.clear();
        for (LocalId i = from; i < to; ++i) {
            if (state_.reach(i) > slow_) {
                fast_.push_back(spot(i));
                cell_.push_back(-1);
                continue;
            }
            std::size_t cell = 0;
            for (int d = 0; d < D; ++d) {
                const int c = static_cast<int>(std::floor((state_.x_ref[i][d] - corner[d]) * per_cell));
                cell = cell * static_cast<std::size_t>(k_) + static_cast<std::size_t>(std::clamp(c, 0, k_ - 1));
            }
            cell_.push_back(static_cast<std::int32_t>(cell));
            ++cell_begin_[base + cell];
        }
        fast_begin_.push_back(static_cast<std::int32_t>(fast_.size()));
        std::int32_t sum = from;
        for (std::size_t c = base; c < cell_begin_.size(); ++c) { // the ends, from where cells are filled backwards
            cell_begin_[c] = sum += cell_begin_[c];
        }
        for (LocalId i = to; i-- > from;) {
            const auto cell = cell_[static_cast<std::size_t>(i - from)];
            if (cell >= 0) {
                spots_[static_cast<std::size_t>(--cell_begin_[base + static_cast<std::size_t>(cell)])] = spot(i);
            }
        }
    }

    Spot<D> spot(LocalId i) const {
        Spot<D> s;
        for (int d = 0; d < D; ++d) {
            s.x[d] = state_.x_ref[i][d];
        }
        s.extent = state_.reach(i);
        s.id = state_.id[i];
        s.row = i;
        return s;
    }

    const State<D>& state_;
    const TileGrid<D>& grid_;
    double slow_ = 0; ///< largest reach of a slow grain [m]
    int k_ = 1;
    std::size_t n_cells_ = 1;
    std::size_t n_own_tiles_ = 0;
    std::vector<TileKey> keys_;
    std::vector<LocalId> begin_, end_;
    std::vector<double> extent_;
    std::vector<std::int32_t> cell_begin_; ///< by tile, n_cells_ + 1 each; into spots_
    std::vector<std::int32_t> cell_;       ///< of the grains of one tile
    std::vector<Spot<D>> spots_;           ///< slow grains, by cell
    std::vector<Spot<D>> fast_;            ///< the others, by tile
    std::vector<std::int32_t> fast_begin_{0};
    std::unordered_map<TileKey, int> slot_of_;
};

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
            const double reach = state_.reach(i);
            find_partners(i, corner, ring, reach, reach + widest);
            for (std::size_t k = 0; k < found_; ++k) {
                a.push_back(i);
                b.push_back(partners_[k].second);
            }
            add_walls(i, reach);
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

template <int D>
void find_candidates(const State<D>& state, const TileGrid<D>& grid, const Walls<D>& walls,
                     const ContactMemory<D>& memory, CandidateSet<D>& set) {
    const CellIndex<D> cells(state, grid);
    TileSearch<D> search(state, grid, walls, cells);
    set.clear();
    std::vector<std::int32_t> n_in_class, at, colour;
    std::vector<std::uint64_t> used;
    for (std::size_t slot = 0; slot < cells.n_own_tiles(); ++slot) {
        search.run(slot);
        const std::size_t n = search.a.size();
        colour_contacts(search.a, search.b, state.n_held(), used, colour);
        const std::int32_t n_classes = n == 0 ? 0 : 1 + *std::max_element(colour.begin(), colour.end());

        Tile tile;
        tile.key = cells.key(slot);
        tile.colour = TileGrid<D>::colour(tile.key);
        tile.grains_begin = cells.begin(slot);
        tile.grains_end = cells.end(slot);
        tile.candidates_begin = set.size();
        tile.candidates_end = set.size() + static_cast<std::int32_t>(n);
        tile.classes_begin = static_cast<std::int32_t>(set.class_begin.size());
        tile.classes_end = tile.classes_begin + n_classes;

        n_in_class.assign(static_cast<std::size_t>(n_classes), 0);
        for (const std::int32_t k : colour) {
            ++n_in_class[static_cast<std::size_t>(k)];
        }
        std::int32_t next = tile.candidates_begin;
        at.clear();
        for (const std::int32_t count : n_in_class) {
            set.class_begin.push_back(next);
            at.push_back(next);
            next += count;
        }
        set.a.resize(static_cast<std::size_t>(tile.candidates_end));
        set.b.resize(set.a.size());
        set.r_n.resize(set.a.size());
        set.r_t.resize(state.carries.friction ? set.a.size() : 0);
        for (std::size_t c = 0; c < n; ++c) {
            const auto to = static_cast<std::size_t>(at[static_cast<std::size_t>(colour[c])]++);
            set.a[to] = search.a[c];
            set.b[to] = search.b[c];
            set.set_impulse(to, memory.find(search.a[c], state.id[search.a[c]], partner_key(state, search.b[c])));
        }
        set.tiles.push_back(tile);
    }
}

template void find_candidates(const State<2>&, const TileGrid<2>&, const Walls<2>&, const ContactMemory<2>&,
                              CandidateSet<2>&);

} // namespace nappe
