#pragma once
// What every deposit must satisfy, found again from its rows alone.

#include "core/deposit.hpp"
#include "core/polygon.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>
#include <vector>

namespace nappe::deposit_checks {

inline Vec<2> centre(const GrainRow<2>& row) {
    return Vec<2>(row.x[0], row.x[1]);
}

/// Calls visit(i, j) once for each pair of rows whose gap is at most `gap`, by a sweep along x.
template <class Visit>
void for_each_pair(const std::vector<GrainRow<2>>& rows, double gap, Visit visit) {
    std::vector<std::size_t> order(rows.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](auto i, auto j) { return rows[i].x[0] < rows[j].x[0]; });
    double r_max = 0;
    for (const auto& row : rows) {
        r_max = std::max(r_max, row.radius);
    }
    for (std::size_t p = 0; p < order.size(); ++p) {
        const auto& a = rows[order[p]];
        for (std::size_t q = p + 1; q < order.size(); ++q) {
            const auto& b = rows[order[q]];
            if (b.x[0] - a.x[0] > a.radius + r_max + gap) {
                break;
            }
            if ((centre(b) - centre(a)).norm() <= a.radius + b.radius + gap) {
                visit(order[p], order[q]);
            }
        }
    }
}

/// Largest overlap of two grains, or of a grain and the profile, over the smaller radius; a centre outside counts as 1.
inline double largest_overlap(const Sample<2>& sample, const std::vector<GrainRow<2>>& rows) {
    double largest = 0;
    for_each_pair(rows, 0, [&](std::size_t i, std::size_t j) {
        const double r_both = rows[i].radius + rows[j].radius;
        const double overlap = r_both - (centre(rows[i]) - centre(rows[j])).norm();
        largest = std::max(largest, overlap / std::min(rows[i].radius, rows[j].radius));
    });
    for (const auto& row : rows) {
        const bool inside = is_inside(sample.profile, centre(row));
        const double overlap = row.radius - distance_to_boundary(sample.profile, centre(row));
        largest = std::max(largest, inside ? overlap / row.radius : 1);
    }
    return largest;
}

/// Grains that do not lie stably between two supports in touch within 1e-9 of the radius: up must be a sum of two of
/// the normals there with shares >= 0 (1e-8 for what 1e-9 of a gap does to a direction).
inline int unsupported(const Sample<2>& sample, const std::vector<GrainRow<2>>& rows, const Vec<2>& up) {
    std::vector<std::vector<Vec<2>>> normals(rows.size());
    const double r_max = sample.radii.max;
    for_each_pair(rows, 1e-9 * r_max, [&](std::size_t i, std::size_t j) {
        const Vec<2> n = (centre(rows[i]) - centre(rows[j])).normalized();
        normals[i].push_back(n);
        normals[j].push_back(-n);
    });
    const std::size_t n_edges = sample.profile.size();
    int count = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        for (std::size_t e = 0; e < n_edges; ++e) {
            const Vec<2> away =
                centre(rows[i]) -
                nearest_on_segment(sample.profile[e], sample.profile[(e + 1) % n_edges], centre(rows[i]));
            if (away.norm() <= rows[i].radius * (1 + 1e-9)) {
                normals[i].push_back(away.normalized());
            }
        }
        bool held = false;
        for (const auto& a : normals[i]) {
            for (const auto& b : normals[i]) {
                const double sine = cross(a, b);
                held = held || (sine > 1e-7 && cross(up, b) / sine >= -1e-8 && cross(a, up) / sine >= -1e-8);
            }
        }
        count += held ? 0 : 1;
    }
    return count;
}

/// Area of the grains over that of the profile.
inline double solid_fraction(const Sample<2>& sample, const std::vector<GrainRow<2>>& rows) {
    double area = 0;
    for (const auto& row : rows) {
        area += M_PI * row.radius * row.radius;
    }
    return area / std::abs(signed_area(sample.profile));
}

/// Places of a lattice (an eighth of the smallest radius) where a disk would touch nothing at all, of a radius one percent
/// up the range: it could fall to a stable place, so the filling must have gone on.
inline int holes(const Sample<2>& sample, const std::vector<GrainRow<2>>& rows) {
    const double r = 0.99 * sample.radii.min + 0.01 * sample.radii.max;
    const double spacing = sample.radii.min / 8;
    Vec<2> low = sample.profile.front();
    Vec<2> high = low;
    for (const auto& corner : sample.profile) {
        low = low.cwiseMin(corner);
        high = high.cwiseMax(corner);
    }
    const int n_x = static_cast<int>((high[0] - low[0]) / spacing) + 1;
    const int n_y = static_cast<int>((high[1] - low[1]) / spacing) + 1;
    std::vector<char> taken(static_cast<std::size_t>(n_x) * n_y, 0);
    for (const auto& row : rows) {
        const double reach = row.radius + r;
        const int i_last = std::min(n_x - 1, static_cast<int>((row.x[0] + reach - low[0]) / spacing));
        const int j_last = std::min(n_y - 1, static_cast<int>((row.x[1] + reach - low[1]) / spacing));
        for (int j = std::max(0, static_cast<int>((row.x[1] - reach - low[1]) / spacing)); j <= j_last; ++j) {
            for (int i = std::max(0, static_cast<int>((row.x[0] - reach - low[0]) / spacing)); i <= i_last; ++i) {
                const Vec<2> point = low + spacing * Vec<2>(i, j);
                if ((point - centre(row)).squaredNorm() < reach * reach) {
                    taken[static_cast<std::size_t>(j) * n_x + i] = 1;
                }
            }
        }
    }
    int count = 0;
    for (int j = 0; j < n_y; ++j) {
        for (int i = 0; i < n_x; ++i) {
            const Vec<2> point = low + spacing * Vec<2>(i, j);
            count += !taken[static_cast<std::size_t>(j) * n_x + i] && is_inside(sample.profile, point) &&
                     distance_to_boundary(sample.profile, point) > r;
        }
    }
    return count;
}

/// Modulus of the mean of exp(6 i angle) over pairs of neighbours higher than `above`: 1 in a crystal of level rows, 0
/// without order that spans the sample.
inline double order_of_rows(const std::vector<GrainRow<2>>& rows, double above) {
    std::complex<double> sum = 0;
    int n = 0;
    for_each_pair(rows, 0.4 * rows.front().radius, [&](std::size_t i, std::size_t j) {
        if (rows[i].x[1] > above && rows[j].x[1] > above) {
            const Vec<2> d = centre(rows[j]) - centre(rows[i]);
            sum += std::pow(std::complex<double>(d[0], d[1]) / d.norm(), 6);
            ++n;
        }
    });
    return std::abs(sum) / n;
}

} // namespace nappe::deposit_checks
