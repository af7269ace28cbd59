#pragma once
// Fields of a granular flow on a grid, by coarse graining (Goldhirsch 2010, Granular Matter 12, 239): every grain is
// spread by a kernel W of range w, so mass and momentum balance exactly and a field needs no cell to average over.
// Everything here is Local; who adds what is the business of commands/flow_fields.hpp.
//
// W is Lucy's (1977), normalised in the plane, r the distance to the grain's centre:
//     W(r) = 5 / (pi w²) (1 + 3 r/w) (1 - r/w)³,   grad W = -60 / (pi w⁴) (1 - r/w)² (x - x_i),   r < w
// Fields at a node: solid fraction = sum A W, rho = sum m W, p = sum m v W, v = p / rho and
// grad v = (grad p - v (x) grad rho) / rho, with the kernel's own gradient: no differences between nodes.

#include "core/types.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

namespace nappe {

/// Below this solid fraction a node is outside the material. Between what lone grains reach (5 r² / w² = 0.08 at the
/// default w = 8 r) and what a right-angled corner of a bed has (a quarter of 0.83).
inline constexpr double least_solid_fraction = 0.2;

/// Nodes at whole multiples of the spacing, so that grids of different extent share theirs.
struct FieldGrid {
    double spacing = 1;                    ///< [m]
    std::int64_t first_x = 0, first_y = 0; ///< node (0, 0) is at (first_x, first_y) spacings
    std::int64_t n_x = 0, n_y = 0;

    double x(std::int64_t i) const { return static_cast<double>(first_x + i) * spacing; } ///< [m]
    double y(std::int64_t j) const { return static_cast<double>(first_y + j) * spacing; } ///< [m]
    std::size_t node(std::int64_t i, std::int64_t j) const { return static_cast<std::size_t>(j * n_x + i); }
    std::int64_t n_nodes() const { return n_x * n_y; }
};

/// Rows [first, first + count) of a grid.
struct GridRows {
    std::int64_t first = 0;
    std::int64_t count = 0;
};

/// A grain as the fields see it. Trivially copyable.
struct FlowGrain {
    GlobalId id = 0;
    std::array<double, 2> x{}; ///< [m]
    std::array<double, 2> v{}; ///< [m/s]
    double mass = 0;           ///< [kg/m]
    double area = 0;           ///< [m²]
    double strain = 0;         ///< cumulative shear strain
};

/// What a node shows; all NaN outside the material but the solid fraction.
struct FieldNode {
    double solid_fraction = 0;
    std::array<double, 2> v{};        ///< [m/s]
    std::array<double, 4> gradient{}; ///< dvx/dx, dvx/dy, dvy/dx, dvy/dy [1/s]
    double shear_rate = 0;            ///< sqrt((Dxx - Dyy)² + 4 Dxy²), D the symmetric part [1/s]
};

/// The rows that a grain at height y reaches; may be beyond the grid.
inline GridRows reached_rows(const FieldGrid& grid, double y, double range) {
    const auto first = static_cast<std::int64_t>(std::ceil((y - range) / grid.spacing)) - grid.first_y;
    const auto last = static_cast<std::int64_t>(std::floor((y + range) / grid.spacing)) - grid.first_y;
    return {first, last - first + 1};
}

/// Calls visit(node within `rows`, dx, dy, r / w) for the nodes of the rows that lie nearer than `range` to (x, y);
/// (dx, dy) leads from there to the node.
template <class Visit>
void for_each_reached(const FieldGrid& grid, const GridRows& rows, const std::array<double, 2>& x, double range,
                      Visit visit) {
    const auto reach = reached_rows(grid, x[1], range);
    const auto last_row = std::min(reach.first + reach.count, rows.first + rows.count);
    const auto first = static_cast<std::int64_t>(std::ceil((x[0] - range) / grid.spacing)) - grid.first_x;
    const auto last = static_cast<std::int64_t>(std::floor((x[0] + range) / grid.spacing)) - grid.first_x;
    for (auto j = std::max(reach.first, rows.first); j < last_row; ++j) {
        const double dy = grid.y(j) - x[1];
        for (auto i = std::max<std::int64_t>(first, 0); i <= std::min(last, grid.n_x - 1); ++i) {
            const double dx = grid.x(i) - x[0];
            const double q = std::sqrt(dx * dx + dy * dy) / range;
            if (q < 1) {
                visit(grid.node(i, j - rows.first), dx, dy, q);
            }
        }
    }
}

/// W [1/m²]; q = r / w < 1.
inline double lucy(double q, double range) {
    return 5 / (std::numbers::pi * range * range) * (1 + 3 * q) * (1 - q) * (1 - q) * (1 - q);
}

/// The sums of some rows of a grid. The bits of a node follow from the order in which grains are added: that of ids.
class CoarseGrain {
public:
    CoarseGrain(const FieldGrid& grid, const GridRows& rows, double range);

    void add(const FlowGrain& grain);

    /// The fields, by rows.
    std::vector<FieldNode> fields() const;

private:
    struct Sums {
        double area = 0;
        double rho = 0;
        std::array<double, 2> grad_rho{};
        std::array<double, 2> p{};
        std::array<double, 4> grad_p{};
    };
    FieldGrid grid_;
    GridRows rows_;
    double range_;
    std::vector<Sums> sums_;
};

/// The mass-weighted mean of FlowGrain::strain around the nodes of some rows; NaN outside the material. Grains come in
/// the order of ids.
std::vector<double> coarse_strain(const FieldGrid& grid, const GridRows& rows, double range,
                                  std::span<const FlowGrain> grains);

/// The value at (x, y) between four nodes, bilinear; nodes outside the material (NaN) leave their weight to the others.
/// Nothing if all four are. @param values of all nodes of the grid
std::optional<double> between_nodes(const FieldGrid& grid, std::span<const double> values,
                                    const std::array<double, 2>& x);

} // namespace nappe
