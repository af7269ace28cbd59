#pragma once
// Grains so much larger than the others that tiles are not made for them (a rock, a piston): few, and each with many
// contacts. They are left out of the search by tiles. Their contacts come behind those of all tiles, in the order of ids,
// on every rank that holds one of the grains they may touch (parallel/large_grains.hpp).

#include "core/scene.hpp"
#include "core/state.hpp"

#include <vector>

namespace nappe {

/// Radius above which a grain is large [m]: tiles.large_above; if that is not given, 4 times the largest radius of the
/// sample; without a sample none is.
template <int D>
double large_above(const Scene<D>& scene) {
    constexpr double times = 4;
    return scene.tiles.large_above > 0 ? scene.tiles.large_above
           : scene.sample              ? times * scene.sample->radii.max
                                       : std::numeric_limits<double>::infinity();
}

/// Largest radius of the grains that tiles are made for [m]; all radii of a sample count.
template <int D>
double largest_radius(const Scene<D>& scene) {
    const double limit = large_above(scene);
    double r = scene.sample ? scene.sample->radii.max : 0.0;
    for (const auto& g : scene.grains) {
        r = g.radius > r && g.radius <= limit ? g.radius : r;
    }
    return r;
}

/// @param dropped also those that come when loading starts
template <int D>
bool has_large_grains(const Scene<D>& scene, bool dropped = true) {
    const double limit = large_above(scene);
    return std::any_of(scene.grains.begin(), scene.grains.end(),
                       [&](const auto& g) { return g.radius > limit && (dropped || !g.drop); });
}

/// Whether the surfaces of two grains were nearer at the last rebuild than both may go until the next, with the reaches
/// of State::reach. The one arithmetic by which all ranks decide on the contacts of large grains.
template <int D>
bool may_touch(const Vec<D>& x, double reach, const Vec<D>& y, double reach_of_y) {
    const double most = reach + reach_of_y;
    return (x - y).squaredNorm() <= most * most;
}

/// Local. Rows of the large grains held, by id.
template <int D>
std::vector<LocalId> large_rows(const State<D>& state) {
    std::vector<LocalId> rows;
    for (LocalId i = 0; i < state.n_held() && state.large_above < std::numeric_limits<double>::infinity(); ++i) {
        if (state.is_large(i)) {
            rows.push_back(i);
        }
    }
    std::sort(rows.begin(), rows.end(), [&](LocalId i, LocalId j) { return state.id[i] < state.id[j]; });
    return rows;
}

} // namespace nappe
