#include "core/features.hpp"

#include <algorithm>

namespace nappe {

template <int D>
Features features_of(const Scene<D>& scene) {
    const auto any = [](const auto& of, auto&& has) { return std::any_of(of.begin(), of.end(), has); };
    const auto& laws = scene.laws;
    Features f;
    f.friction = any(laws, [](const auto& law) { return law.friction > 0; });
    f.mixed_friction = any(laws, [&](const auto& law) { return law.friction != laws.front().friction; });
    f.restitution = any(laws, [](const auto& law) { return law.restitution > 0; });
    f.cohesion = any(laws, [](const auto& law) { return law.gamma > 0; });
    f.turning = f.friction || any(scene.grains, [](const auto& g) { return !g.spin.isZero(0); });
    f.cells = !scene.output.cells.empty();
    f.layers = (scene.sample && !scene.sample->layer_tops.empty()) ||
               any(scene.grains, [](const auto& g) { return g.layer != 1; });
    f.driven_walls = any(scene.walls, [](const auto& wall) { return wall.motion.has_value(); });
    return f;
}

template Features features_of(const Scene<2>&);

} // namespace nappe
