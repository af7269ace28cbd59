#include "commands/drop.hpp"

#include "core/error.hpp"
#include "core/initial_grains.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace nappe {

namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// How far a disk at x goes in direction g until it touches this grain [m]; < 0: it overlaps it from the start.
double way_to(const GrainRow<2>& grain, const Vec<2>& x, double radius, const Vec<2>& g) {
    const Vec<2> d = Vec<2>(grain.x[0], grain.x[1]) - x;
    const double reach = grain.radius + radius;
    const double along = d.dot(g), aside = g[0] * d[1] - g[1] * d[0];
    if (d.squaredNorm() < reach * reach) {
        return -1;
    }
    return along > 0 && std::abs(aside) < reach ? along - std::sqrt(reach * reach - aside * aside) : never;
}

} // namespace

std::int64_t n_dropped(const Scene<2>& scene) {
    return std::count_if(scene.grains.begin(), scene.grains.end(), [](const auto& g) { return g.drop; });
}

std::vector<GrainRow<2>> with_dropped(const Communicator& comm, const Scene<2>& scene,
                                      std::vector<GrainRow<2>> grains) {
    auto id = comm.sum(static_cast<std::int64_t>(grains.size()));
    for (std::size_t k = 0; k < scene.grains.size(); ++k) {
        const auto& single = scene.grains[k];
        if (!single.drop) {
            continue;
        }
        const Vec<2> down = scene.gravity.normalized();
        double way = never;
        for (const auto& grain : grains) {
            const double to_it = way_to(grain, single.position, single.radius, down);
            way = to_it < way ? to_it : way;
        }
        way = -comm.max(-way);
        if (!(way >= 0 && way < never)) {
            const Vec<2> from = single.position + scene.origin;
            throw InputError(fmt::format("grains.{}.drop: the way along gravity from its position must lead to a "
                                         "grain, found {} from [{}, {}] with "
                                         "radius {} [m]; {}",
                                         k, way < 0 ? "it inside of one" : "none below", from[0], from[1],
                                         single.radius, way < 0 ? "start higher" : "move it over the sample"));
        }
        if (comm.is_root()) {
            auto row = single_grain(scene, single, id);
            row.x = {single.position[0] + way * down[0], single.position[1] + way * down[1]};
            grains.push_back(row);
        }
        ++id;
    }
    return grains;
}

} // namespace nappe
