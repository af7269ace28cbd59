#pragma once
// The zone between a block that a wall pushes and the ground that stays (seeds/000 §5.3.2): to the left of the left
// limit the velocity is the wall's, to the right of the right limit it is nought. The block comes from the left. Local.

#include "core/measures/coarse_grain.hpp"
#include "core/measures/line_fit.hpp"
#include "core/measures/surface.hpp"

#include <span>
#include <vector>

namespace nappe {

/// What rows and differences count.
struct ZoneRule {
    Vec<2> drive = Vec<2>::Zero(); ///< V0, velocity of the wall [m/s]
    double tolerance = 0.1;        ///< difference that still counts as rigid or at rest, over |V0|
    double floor = 0;              ///< height of the fault's tip [m]
    double range = 0;              ///< of the kernel [m]: so near to the floor or the surface nothing counts
};

/// Whether the kernel of a node lies in the material at the start: a range above the floor that was, a range below the
/// surface that is. Over a block that has risen since, kernels within a range of its top reach into it.
bool is_inside(const Surface& surface, const ZoneRule& rule, double x, double y);

/// Points of both limits, at = height y, value = x, in the order of rows.
struct ZonePoints {
    std::vector<FitPoint> left, right;
};

/// Row by row, from the first node of the material on: the last x up to which |v - V0| (from the left) or |v| (from the
/// right) is within the tolerance throughout, between nodes by linear interpolation. A row has no point if it begins
/// outside the tolerance, ends within it, or meets its limit outside of `is_inside`.
/// @param nodes of `rows`, by rows
ZonePoints zone_points(const FieldGrid& grid, const GridRows& rows, std::span<const FieldNode> nodes,
                       const Surface& surface, const ZoneRule& rule);

/// A straight limit x(y). NaN where there are fewer than three points.
struct ZoneLine {
    double x = 0;        ///< where it meets the floor [m]
    double angle = 0;    ///< to the horizontal, in (0, pi): above pi/2 it leans to the left [rad]
    double residual = 0; ///< root mean square of horizontal distances [m]
    double points = 0;   ///< that were used
};

/// Least squares of x on y, since limits may be steep, outliers left out (core/measures/line_fit.hpp); the deviation
/// that is always allowed is a tenth of the spacing, finer than a limit can be placed.
ZoneLine zone_line(std::span<const FitPoint> points, const ZoneRule& rule, double spacing);

} // namespace nappe
