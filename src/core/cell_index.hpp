#pragma once
// Where the search for candidates looks: held grains by tile and, in a tile, by cells.

#include "core/error.hpp"
#include "core/state.hpp"
#include "core/tile_grid.hpp"

#include <algorithm>
#include <array>
#include <unordered_map>
#include <vector>

namespace nappe {

/// What the search asks of a grain.
template <int D>
struct Spot {
    std::array<double, D> x;
    double extent; ///< State::reach [m]
    GlobalId id;
    LocalId row;
};

/// Grains of all held tiles, each tile cut into k^D cells about as wide as two grains, so that a search looks at few of
/// them. The few that have long ways to go are kept apart, or every search around them would have to look as far; large
/// ones are left out.
template <int D>
class CellIndex {
public:
    using Ring = std::array<int, TileGrid<D>::n_ring>;

    CellIndex(const State<D>& state, const TileGrid<D>& grid) : state_(state), grid_(grid) {
        double widest = 0;
        for (LocalId i = 0; i < state.n_held(); ++i) {
            widest = state.radius[i] > widest && !state.is_large(i) ? state.radius[i] : widest;
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
                extent = state_.is_large(j) ? extent : std::max(extent, state_.reach(j));
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
            if (state_.is_large(i)) {
                cell_.push_back(-1);
                continue;
            }
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

} // namespace nappe
