#pragma once
// Questions about closed polygons that the rules on a scene ask. Points in order, either orientation, the last joined to
// the first. Internal to src/io and src/commands. Every function is Local.

#include "core/types.hpp"

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace nappe::scene_file {

using Polygon = std::vector<Vec<2>>;

double area(const Polygon& polygon); ///< [m²], >= 0

double distance_to_segment(const Vec<2>& p, const Vec<2>& a, const Vec<2>& b); ///< [m]

bool segments_touch(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c, const Vec<2>& d);

/// First two edges (edge k goes from point k to the next) that meet elsewhere than in a joint they share, or that fold
/// back onto each other.
std::optional<std::pair<std::size_t, std::size_t>> crossing_edges(const Polygon& polygon);

/// Distance from p to the boundary [m]: positive inside, negative outside.
double depth(const Polygon& polygon, const Vec<2>& p);

/// Whether a circle fits inside, up to a thousandth of its radius.
bool holds_circle(const Polygon& polygon, double radius);

/// How deep a segment reaches inside [m]; <= 0 if it stays outside or on the boundary. Exact where a piece of it is
/// deepest at its ends or its middle, a lower bound elsewhere: right about the sign.
double depth_of_segment(const Polygon& polygon, const Vec<2>& a, const Vec<2>& b);

} // namespace nappe::scene_file
