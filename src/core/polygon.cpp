#include "core/polygon.hpp"

#include <cmath>
#include <fmt/core.h>
#include <limits>

namespace nappe {

namespace {

std::string text(const Vec<2>& point) {
    return fmt::format("[{}, {}]", point[0], point[1]);
}

/// Proper crossing or touching; of collinear segments an overlap is found through their ends.
bool segments_meet(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c, const Vec<2>& d) {
    const double c_side = cross(b - a, c - a);
    const double d_side = cross(b - a, d - a);
    const double a_side = cross(d - c, a - c);
    const double b_side = cross(d - c, b - c);
    if (((c_side > 0 && d_side < 0) || (c_side < 0 && d_side > 0)) &&
        ((a_side > 0 && b_side < 0) || (a_side < 0 && b_side > 0))) {
        return true;
    }
    return nearest_on_segment(a, b, c) == c || nearest_on_segment(a, b, d) == d || nearest_on_segment(c, d, a) == a ||
           nearest_on_segment(c, d, b) == b;
}

} // namespace

double signed_area(Polygon polygon) {
    double twice = 0;
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
        twice += cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]);
    }
    return twice / 2;
}

bool is_inside(Polygon polygon, const Vec<2>& point) {
    bool inside = false;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec<2>& a = polygon[i];
        const Vec<2>& b = polygon[(i + 1) % polygon.size()];
        if ((a[1] > point[1]) != (b[1] > point[1])) {
            const bool left_of_edge = cross(b - a, point - a) > 0;
            if (left_of_edge == (b[1] > a[1])) {
                inside = !inside;
            }
        }
    }
    return inside;
}

Vec<2> nearest_on_segment(const Vec<2>& a, const Vec<2>& b, const Vec<2>& point) {
    const Vec<2> along = b - a;
    const double projection = along.dot(point - a);
    const double length2 = along.dot(along);
    if (!(projection > 0)) {
        return a;
    }
    if (projection >= length2) {
        return b;
    }
    return a + along * (projection / length2);
}

double distance_to_boundary(Polygon polygon, const Vec<2>& point) {
    double least2 = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec<2> nearest = nearest_on_segment(polygon[i], polygon[(i + 1) % polygon.size()], point);
        const double distance2 = (nearest - point).squaredNorm();
        least2 = distance2 < least2 ? distance2 : least2;
    }
    return std::sqrt(least2);
}

double segment_distance(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c, const Vec<2>& d) {
    if (segments_meet(a, b, c, d)) {
        return 0;
    }
    const double at_ends[] = {
        (nearest_on_segment(a, b, c) - c).squaredNorm(), (nearest_on_segment(a, b, d) - d).squaredNorm(),
        (nearest_on_segment(c, d, a) - a).squaredNorm(), (nearest_on_segment(c, d, b) - b).squaredNorm()};
    double least2 = at_ends[0];
    for (const double distance2 : at_ends) {
        least2 = distance2 < least2 ? distance2 : least2;
    }
    return std::sqrt(least2);
}

std::string polygon_fault(Polygon polygon) {
    const std::size_t n = polygon.size();
    if (n < 3) {
        return fmt::format("a polygon has at least 3 corners; found {}", n);
    }
    for (std::size_t i = 0; i < n; ++i) {
        const Vec<2>& a = polygon[i];
        const Vec<2>& b = polygon[(i + 1) % n];
        if (!std::isfinite(a[0]) || !std::isfinite(a[1])) {
            return fmt::format("corners are finite numbers; found {} (corner {})", text(a), i + 1);
        }
        if (a == b) {
            return fmt::format("no corner follows itself, the last is joined to the first without repeating it; "
                               "found {} twice (corner {})",
                               text(a), i + 1);
        }
        const Vec<2>& c = polygon[(i + 2) % n];
        if (cross(b - a, c - b) == 0 && (b - a).dot(c - b) < 0) {
            return fmt::format("an edge does not run back over the one before; found {} {} {}", text(a), text(b),
                               text(c));
        }
    }
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = i + 2; j < n; ++j) {
            const bool share_a_corner = i == 0 && j == n - 1;
            if (!share_a_corner && segments_meet(polygon[i], polygon[i + 1], polygon[j], polygon[(j + 1) % n])) {
                return fmt::format("edges do not cross or touch; found {}-{} meeting {}-{}", text(polygon[i]),
                                   text(polygon[i + 1]), text(polygon[j]), text(polygon[(j + 1) % n]));
            }
        }
    }
    if (signed_area(polygon) == 0) {
        return "a polygon encloses an area; found corners on one line";
    }
    return {};
}

} // namespace nappe
