// The cells of a deposit's Packing: where disks and edges are looked up.

#include "core/deposit_packing.hpp"

#include <algorithm>
#include <cmath>

namespace nappe {

int Packing::column(double s) const {
    const double i = (s - low_[0]) / cell_size_;
    return i > 0 ? std::min(static_cast<int>(std::min(i, 2e9)), n_columns_ - 1) : 0;
}

int Packing::row(double z) const {
    const double j = (z - low_[1]) / cell_size_;
    return j > 0 ? std::min(static_cast<int>(std::min(j, 2e9)), n_rows_ - 1) : 0;
}

void Packing::make_grid() {
    low_ = high_ = profile_.front();
    for (const Vec<2>& corner : profile_) {
        low_ = low_.cwiseMin(corner);
        high_ = high_.cwiseMax(corner);
    }
    const Vec<2> size = high_ - low_;
    // A thin profile across a large box would be nearly all empty cells: larger cells then, and slower, not more
    // memory.
    constexpr double most_cells = 5e7;
    cell_size_ = std::max(2 * r_max_, std::sqrt(size[0] / most_cells * size[1]));
    cell_size_ = std::max(cell_size_, std::max(size[0], size[1]) / most_cells);
    n_columns_ = static_cast<int>(size[0] / cell_size_) + 1;
    n_rows_ = static_cast<int>(size[1] / cell_size_) + 1;
    newest_disk_.assign(cell(0, n_rows_), -1);
}

/// Visits the cells that lie within `reach` of the edge, and a few more.
template <class Visit>
void Packing::for_each_cell_near(const Edge& edge, double reach, Visit visit) const {
    const Vec<2> end = edge.start + edge.length * edge.direction;
    const Vec<2>& lower = edge.start[1] < end[1] ? edge.start : end;
    const Vec<2>& upper = edge.start[1] < end[1] ? end : edge.start;
    const double slope = upper[1] > lower[1] ? (upper[0] - lower[0]) / (upper[1] - lower[1]) : 0;
    const int last_row = row(upper[1] + reach);
    for (int j = row(lower[1] - reach); j <= last_row; ++j) {
        // The piece of the edge that is within reach of this row of cells.
        const double floor = low_[1] + j * cell_size_;
        const double from = std::max(floor - reach, lower[1]);
        const double to = std::min(floor + cell_size_ + reach, upper[1]);
        const bool level = !(upper[1] > lower[1]);
        const double s_from = level ? lower[0] : lower[0] + slope * (from - lower[1]);
        const double s_to = level ? upper[0] : lower[0] + slope * (to - lower[1]);
        const int last_column = column(std::max(s_from, s_to) + reach);
        for (int i = column(std::min(s_from, s_to) - reach); i <= last_column; ++i) {
            visit(cell(i, j));
        }
    }
}

void Packing::enter_edges_into_grid() {
    const double reach = 3 * r_max_ * (1 + 1e-6);
    first_edge_.assign(newest_disk_.size() + 1, 0);
    for (const Edge& edge : edges_) {
        for_each_cell_near(edge, reach, [&](std::size_t home) { ++first_edge_[home + 1]; });
    }
    for (std::size_t home = 0; home < newest_disk_.size(); ++home) {
        first_edge_[home + 1] += first_edge_[home];
    }
    edge_of_cell_.resize(static_cast<std::size_t>(first_edge_.back()));
    auto next = first_edge_;
    for (std::size_t e = 0; e < edges_.size(); ++e) {
        for_each_cell_near(edges_[e], reach,
                           [&](std::size_t home) { edge_of_cell_[next[home]++] = static_cast<std::int32_t>(e); });
    }
}

} // namespace nappe
