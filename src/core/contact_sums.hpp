#pragma once
// What series report of contacts: stress of cells, forces on walls and their work, summed over all steps of a reporting
// interval. By tile in the order of candidates, then exactly, so that the figures do not depend on ranks.

#include "core/exact_sum.hpp"
#include "core/gauge_sums.hpp"
#include "core/state.hpp"
#include "core/walls.hpp"

#include <vector>

namespace nappe {

template <int D>
class ContactSums {
public:
    ContactSums(std::size_t n_cells, const Walls<D>& walls, const std::vector<Gauge>& gauges = {})
        : walls_(&walls), gauges_(gauges, walls) {
        cells_.resize(n_cells * D * D);
        tile_cells_.assign(cells_.size(), 0.0);
        walls_sum_.resize(static_cast<std::size_t>(walls.n_walls()) * D);
        tile_walls_.assign(walls_sum_.size(), 0.0);
    }

    /// Local. One contact of the current tile: impulse r on a (-r on b) along unit normal n from b to a [N s].
    void add(const State<D>& state, LocalId a, LocalId b, const Vec<D>& n, const Vec<D>& r) {
        const bool wall = b >= state.n_held();
        const std::uint64_t of_a = state.cells_of(a), of_b = wall ? 0 : state.cells_of(b);
        if (of_a != 0) {
            add_to_cells(of_a, state.radius[a], n, r);
        }
        if (of_b != 0) {
            add_to_cells(of_b, state.radius[b], n, r); // both factors change sign
        }
        if (wall) {
            gauges_.add(b - state.n_held(), state.x[a], n, r);
            const auto w = static_cast<std::size_t>(walls_->feature(b - state.n_held()).wall);
            for (int d = 0; d < D; ++d) {
                tile_walls_[w * D + static_cast<std::size_t>(d)] -= r[d];
            }
            // Of the kinetic energy's change, which is exact with the mean of both velocities.
            tile_work_ += r.dot(0.5 * (walls_->v_old[w] + walls_->v[w]));
            any_ = true;
        }
    }

    /// Local. Ends a tile.
    void end_tile() {
        if (!any_) {
            return;
        }
        any_ = false;
        gauges_.end_tile();
        for (std::size_t k = 0; k < cells_.size(); ++k) {
            if (tile_cells_[k] != 0) {
                cells_[k].add(tile_cells_[k]);
                tile_cells_[k] = 0;
            }
        }
        for (std::size_t k = 0; k < walls_sum_.size(); ++k) {
            if (tile_walls_[k] != 0) {
                walls_sum_[k].add(tile_walls_[k]);
                tile_walls_[k] = 0;
            }
        }
        work_.add(tile_work_);
        tile_work_ = 0;
    }

    /// Local. Ends `n` steps whose impulses were added up.
    void end_steps(int n) { n_steps_ += n; }
    std::int64_t n_steps() const { return n_steps_; }

    /// Calls f(ExactSum&) for each sum but those of gauges, in the same order on every rank: to add them up over ranks.
    template <class F>
    void for_each_sum(F&& f) {
        for (auto& s : cells_) {
            f(s);
        }
        for (auto& s : walls_sum_) {
            f(s);
        }
        f(work_);
    }

    /// Summed over intervals of their own.
    GaugeSums<D>& gauges() { return gauges_; }

    /// Sum over steps, grains of the cell and their contacts of r ⊗ (x_i - x_c) [N m s], row-major. Compression
    /// positive.
    double cell_moment(std::size_t cell, int row, int column) const {
        return cells_[cell * D * D + static_cast<std::size_t>(row * D + column)].value();
    }

    /// Impulse of the grains on a wall over the interval [N s].
    Vec<D> wall_impulse(std::size_t wall) const {
        Vec<D> sum;
        for (int d = 0; d < D; ++d) {
            sum[d] = walls_sum_[wall * D + static_cast<std::size_t>(d)].value();
        }
        return sum;
    }

    /// Work that walls did on grains over the interval [J].
    double wall_work() const { return work_.value(); }

    /// All but gauges.
    void clear() {
        for_each_sum([](ExactSum& s) { s.clear(); });
        n_steps_ = 0;
    }

private:
    /// The arm from contact point to centre is r n for both bodies, up to a sign that the impulse shares: as the
    /// dynamics have it.
    void add_to_cells(std::uint64_t cells, double radius, const Vec<D>& n, const Vec<D>& r) {
        any_ = true;
        for (std::size_t k = 0; cells != 0; ++k, cells >>= 1) {
            if ((cells & 1) == 0) {
                continue;
            }
            for (int i = 0; i < D; ++i) {
                for (int j = 0; j < D; ++j) {
                    tile_cells_[k * D * D + static_cast<std::size_t>(i * D + j)] += r[i] * (radius * n[j]);
                }
            }
        }
    }

    const Walls<D>* walls_;
    GaugeSums<D> gauges_;
    std::vector<ExactSum> cells_, walls_sum_;
    std::vector<double> tile_cells_, tile_walls_;
    ExactSum work_;
    double tile_work_ = 0;
    bool any_ = false;
    std::int64_t n_steps_ = 0;
};

} // namespace nappe
