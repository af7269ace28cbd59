#pragma once
// Questions about closed polygons that the rules on a scene ask, beyond those of core/polygon.hpp. Internal to src/io.
// Every function is Local.

#include "core/polygon.hpp"

#include <cstddef>
#include <optional>
#include <utility>

namespace nappe::scene_file {

/// First two edges (edge k goes from point k to the next) that meet elsewhere than in a joint they share, or that fold
/// back onto each other.
std::optional<std::pair<std::size_t, std::size_t>> crossing_edges(Polygon polygon);

/// Distance from p to the boundary [m]: positive inside, negative outside.
double depth(Polygon polygon, const Vec<2>& p);

/// Whether a circle fits inside, up to a thousandth of its radius.
bool holds_circle(Polygon polygon, double radius);

/// How deep a segment reaches inside [m]; <= 0 if it stays outside or on the boundary. Exact where a piece of it is
/// deepest at its ends or its middle, a lower bound elsewhere: right about the sign.
double depth_of_segment(Polygon polygon, const Vec<2>& a, const Vec<2>& b);

} // namespace nappe::scene_file
