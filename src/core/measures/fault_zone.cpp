#include "core/measures/fault_zone.hpp"

namespace nappe {

namespace {

/// One row, node by node from one end.
struct RowWalk {
    std::span<const FieldNode> nodes;
    bool from_right = false;

    std::size_t size() const { return nodes.size(); }
    std::size_t at(std::size_t k) const { return from_right ? nodes.size() - 1 - k : k; }
    const FieldNode& operator[](std::size_t k) const { return nodes[at(k)]; }
};

/// The place between two nodes of a row, counted from its left end, where the difference from `reference` passes
/// `limit`.
std::optional<double> passing(const RowWalk& row, const Vec<2>& reference, double limit) {
    const auto difference = [&](std::size_t k) {
        return std::hypot(row[k].v[0] - reference[0], row[k].v[1] - reference[1]); // NaN outside the material
    };
    std::size_t k = 0;
    while (k < row.size() && std::isnan(difference(k))) {
        ++k;
    }
    if (k == row.size() || !(difference(k) <= limit)) {
        return std::nullopt;
    }
    while (k + 1 < row.size() && difference(k + 1) <= limit) {
        ++k;
    }
    if (k + 1 == row.size() || std::isnan(difference(k + 1))) {
        return std::nullopt;
    }
    const double share = (limit - difference(k)) / (difference(k + 1) - difference(k));
    return static_cast<double>(row.at(k)) + (row.from_right ? -share : share);
}

} // namespace

bool is_inside(const Surface& surface, const ZoneRule& rule, double x, double y) {
    return y >= rule.floor + rule.range && y + rule.range <= surface.height_at(x);
}

ZonePoints zone_points(const FieldGrid& grid, const GridRows& rows, std::span<const FieldNode> nodes,
                       const Surface& surface, const ZoneRule& rule) {
    ZonePoints points;
    const double limit = rule.tolerance * rule.drive.norm();
    if (!(limit > 0)) {
        return points;
    }
    for (std::int64_t j = 0; j < rows.count; ++j) {
        const double y = grid.y(rows.first + j);
        const auto row = nodes.subspan(grid.node(0, j), static_cast<std::size_t>(grid.n_x));
        const auto find = [&](bool from_right, const Vec<2>& reference, std::vector<FitPoint>& found) {
            if (const auto place = passing({row, from_right}, reference, limit)) {
                const double x = (static_cast<double>(grid.first_x) + *place) * grid.spacing;
                if (is_inside(surface, rule, x, y)) {
                    found.push_back({y, x});
                }
            }
        };
        find(false, rule.drive, points.left);
        find(true, Vec<2>::Zero(), points.right);
    }
    return points;
}

ZoneLine zone_line(std::span<const FitPoint> points, const ZoneRule& rule, double spacing) {
    const auto line = fit_line_robustly(points, 0.1 * spacing);
    // atan2 of NaN is NaN; x on y, so a slope of 0 is upright.
    return {line.offset + line.slope * rule.floor, std::atan2(1.0, line.slope), line.residual,
            static_cast<double>(line.points)};
}

} // namespace nappe
