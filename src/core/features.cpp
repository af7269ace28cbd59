#include "core/features.hpp"

#include <algorithm>

namespace nappe {

namespace {

struct Kept {
    int impulses, velocities;
};

Kept kept_by(SolverSettings::Method method) {
    using enum SolverSettings::Method;
    switch (method) {
    case nsgs:
        return {0, 0};
    case ansgs:
        return {1, 1};
    case apgd:
        return {1, 2};
    case nncg:
    case cpg:
        return {2, 2};
    case cundall:
        return {0, 0};
    }
    return {};
}

} // namespace

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
    f.impulses_kept = f.velocities_kept = 0;
    f.kept_normals = f.kept_gaps = f.correction = f.adaptive = f.single = f.smooth = false;
    for (const auto& stage : scene.stages) {
        f.correction = f.correction || stage.solver.position_correction > 0;
        f.kept_normals = f.kept_normals || std::min(stage.solver.geometry_every, stage.solver.substeps) > 1;
        f.smooth = f.smooth || is_smooth(stage.solver);
        f.kept_gaps = f.kept_normals || f.correction || f.smooth;
        f.adaptive = f.adaptive || stage.solver.adaptive.has_value();
        f.single = f.single || stage.solver.precision == SolverSettings::Precision::single;
        const auto kept = kept_by(stage.solver.method);
        f.impulses_kept = std::max(f.impulses_kept, kept.impulses);
        f.velocities_kept = std::max(f.velocities_kept, kept.velocities);
    }
    return f;
}

template Features features_of(const Scene<2>&);

} // namespace nappe
