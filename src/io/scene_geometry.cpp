#include "io/scene_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

namespace nappe::scene_file {

namespace {

const Vec<2>& next(Polygon polygon, std::size_t k) {
    return polygon[k + 1 < polygon.size() ? k + 1 : 0];
}

/// Sign of the turn from a over b to c.
int turn(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c) {
    const double t = cross(b - a, c - a);
    return t > 0 ? 1 : (t < 0 ? -1 : 0);
}

/// p is on the line of a and b; is it between them?
bool within_box(const Vec<2>& p, const Vec<2>& a, const Vec<2>& b) {
    return (p.array() >= a.array().min(b.array())).all() && (p.array() <= a.array().max(b.array())).all();
}

bool segments_touch(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c, const Vec<2>& d) {
    const int c_side = turn(a, b, c);
    const int d_side = turn(a, b, d);
    const int a_side = turn(c, d, a);
    const int b_side = turn(c, d, b);
    if (c_side * d_side < 0 && a_side * b_side < 0) {
        return true;
    }
    return (c_side == 0 && within_box(c, a, b)) || (d_side == 0 && within_box(d, a, b)) ||
           (a_side == 0 && within_box(a, c, d)) || (b_side == 0 && within_box(b, c, d));
}

} // namespace

std::optional<std::pair<std::size_t, std::size_t>> crossing_edges(Polygon polygon) {
    const std::size_t n = polygon.size();
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = i + 1; j < n; ++j) {
            const bool j_follows = j == i + 1;
            const bool i_follows = i == 0 && j + 1 == n;
            if (j_follows || i_follows) {
                const Vec<2>& joint = j_follows ? polygon[j] : polygon[i];
                const Vec<2> into = joint - (j_follows ? polygon[i] : polygon[j]);
                const Vec<2> out = (j_follows ? next(polygon, j) : next(polygon, i)) - joint;
                if (cross(into, out) == 0 && into.dot(out) < 0) {
                    return std::pair(i, j);
                }
            } else if (segments_touch(polygon[i], next(polygon, i), polygon[j], next(polygon, j))) {
                return std::pair(i, j);
            }
        }
    }
    return std::nullopt;
}

double depth(Polygon polygon, const Vec<2>& p) {
    const double distance = distance_to_boundary(polygon, p);
    return is_inside(polygon, p) ? distance : -distance;
}

bool holds_circle(Polygon polygon, double radius) {
    // A quadtree of squares, the most promising first: no point of a square is deeper than its centre's depth plus half
    // its diagonal.
    struct Square {
        Vec<2> centre;
        double half = 0;
        double depth = 0;
        double bound() const { return depth + half * std::sqrt(2.0); }
        bool operator<(const Square& other) const { return bound() < other.bound(); }
    };
    Vec<2> low = polygon[0];
    Vec<2> high = polygon[0];
    for (const auto& p : polygon) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    const double wanted = radius * (1 - 1e-3);
    const Vec<2> middle = (low + high) / 2;
    std::priority_queue<Square> squares;
    squares.push({middle, (high - low).maxCoeff() / 2, depth(polygon, middle)});
    // The limit keeps absurd slivers from taking for ever; what it leaves open, the deposit finds out.
    for (int looked = 0; !squares.empty() && looked < 200000; ++looked) {
        const Square square = squares.top();
        squares.pop();
        if (square.depth >= wanted) {
            return true;
        }
        if (square.bound() < wanted) {
            return false;
        }
        const double half = square.half / 2;
        for (const auto& [x, y] : {std::pair(-half, -half), {half, -half}, {-half, half}, {half, half}}) {
            const Vec<2> centre = square.centre + Vec<2>(x, y);
            squares.push({centre, half, depth(polygon, centre)});
        }
    }
    return true;
}

double depth_of_segment(Polygon polygon, const Vec<2>& a, const Vec<2>& b) {
    // Cut where the segment meets an edge: each piece is inside, outside or on the boundary as a whole.
    std::vector<double> cuts = {0, 1};
    const Vec<2> along = b - a;
    for (std::size_t k = 0; k < polygon.size(); ++k) {
        const Vec<2> edge = next(polygon, k) - polygon[k];
        const double det = cross(along, edge);
        if (det != 0) {
            const double t = cross(polygon[k] - a, edge) / det;
            const double s = cross(polygon[k] - a, along) / det;
            constexpr double slack = 1e-9;
            if (t > 0 && t < 1 && s > -slack && s < 1 + slack) {
                cuts.push_back(t);
            }
        }
    }
    std::sort(cuts.begin(), cuts.end());
    double deepest = std::max(depth(polygon, a), depth(polygon, b));
    for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
        deepest = std::max(deepest, depth(polygon, a + (cuts[k] + cuts[k + 1]) / 2 * along));
    }
    return deepest;
}

} // namespace nappe::scene_file
