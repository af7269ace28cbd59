// What tiles, large grains and those to be dropped ask of a scene.

#include "core/large_grains.hpp"
#include "io/scene_rules.hpp"

#include <fmt/format.h>

namespace nappe::scene_file {

namespace {

/// A tile touches no grain of another tile of its colour only if it is wider than twice the reach (docs/architecture.md).
void check_sides(const Scene<2>& scene, Problems& problems) {
    const double r_max = largest_radius(scene);
    const double side = scene.tiles.side_for(r_max);
    const double skin = scene.tiles.skin_for(r_max);
    const double range = largest_range(scene);
    const double least = 2 * (2 * r_max + skin + range);
    if (!(side > least)) {
        problems.add(
            scene.tiles.side > 0 ? "tiles.side" : "tiles.skin",
            fmt::format("side must be > 2 (2 r_max + skin + d_w) = {:.6g} [m], found side {:.6g} with skin {:.6g}, "
                        "d_w {:.6g} and r_max {:.6g}; give a wider side or a smaller skin",
                        least, side, skin, range, r_max));
    }
}

/// What was not made for contacts that many ranks have.
void check_large(const Scene<2>& scene, Problems& problems) {
    if (scene.sample && scene.tiles.large_above > 0 && scene.tiles.large_above < scene.sample->radii.max) {
        problems.add(
            "tiles.large_above",
            fmt::format("must be at least sample.radius.max = {} [m], found {}: large grains are few; raise it",
                        scene.sample->radii.max, scene.tiles.large_above));
    }
    if (!has_large_grains(scene)) {
        return;
    }
    for (const auto& stage : scene.stages) {
        const auto refuse = [&](const char* key, const std::string& found, const char* remedy) {
            problems.add(
                fmt::format("stages.{}.solver.{}", stage.name, key),
                fmt::format("must not be set where a grain is larger than tiles.large_above = {} [m], found {}; {}",
                            large_above(scene), found, remedy));
        };
        if (stage.solver.adaptive) {
            refuse("adaptive", fmt::format("{}", *stage.solver.adaptive), "remove it");
        }
        if (stage.solver.coupling == SolverSettings::Coupling::sweep) {
            refuse("coupling", "\"sweep\"", "take \"colour\"");
        }
    }
}

/// What is to be dropped needs a direction to fall in.
void check_drops(const Scene<2>& scene, Problems& problems) {
    for (std::size_t i = 0; i < scene.grains.size(); ++i) {
        if (scene.grains[i].drop && scene.gravity.isZero(0)) {
            problems.add(
                fmt::format("grains.{}.drop", i),
                "must be false without world.gravity, found true: a grain is dropped along it; give gravity, or "
                "the place itself");
        }
    }
}

} // namespace

void check_tiles(const Scene<2>& scene, Problems& problems) {
    check_sides(scene, problems);
    check_large(scene, problems);
    check_drops(scene, problems);
}

} // namespace nappe::scene_file
