#pragma once
// Closed polygons in the plane, given by their corners in order; the last is joined to the first.

#include "core/types.hpp"

#include <span>
#include <string>

namespace nappe {

using Polygon = std::span<const Vec<2>>;

/// The component out of the plane of a × b; positive if b points to the left of a.
inline double cross(const Vec<2>& a, const Vec<2>& b) {
    return a[0] * b[1] - a[1] * b[0];
}

/// Area [m²], positive if the corners run counter-clockwise. Local.
double signed_area(Polygon polygon);

/// Whether a point lies inside (even-odd rule); on the boundary itself the answer may be either. Local.
bool is_inside(Polygon polygon, const Vec<2>& point);

/// The point of the segment from a to b that is nearest to a point; a == b is allowed. Local.
Vec<2> nearest_on_segment(const Vec<2>& a, const Vec<2>& b, const Vec<2>& point);

/// Distance [m] from a point, inside or outside, to the nearest edge. Local.
double distance_to_boundary(Polygon polygon, const Vec<2>& point);

/// Least distance [m] between two segments, 0 if they meet. Local.
double segment_distance(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c, const Vec<2>& d);

/// The first rule that the corners break, with the values found, or an empty text: finite numbers, at least three
/// corners, no corner repeated, no edges that cross or touch, an area. Checks all pairs of edges. Local.
std::string polygon_fault(Polygon polygon);

} // namespace nappe
