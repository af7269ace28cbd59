// Rules on how much a scene asks for: what would fill the memory or never end is refused with its number, not tried.
#include "core/deposit.hpp"
#include "io/scene_rules.hpp"

#include <fmt/format.h>

#include <cmath>

namespace nappe::scene_file {

namespace {

/// Rules compare all pairs of edges, and each segment of a wall with every edge.
constexpr std::size_t most_corners = 4096;
constexpr std::size_t most_wall_points = 16384;

/// Doubles count steps exactly up to here; the default of at_most is 1000 s, whatever h.
constexpr double most_steps = 0x1p53;

void check_points(const Scene<2>& scene, Problems& problems) {
    if (scene.sample && scene.sample->profile.size() > most_corners) {
        problems.add("sample.profile", fmt::format("must have at most {} points, found {}; leave out what is finer "
                                                   "than a grain",
                                                   most_corners, scene.sample->profile.size()));
    }
    std::size_t n_points = 0;
    for (const auto& wall : scene.walls) {
        n_points += wall.points.size();
    }
    if (n_points > most_wall_points) {
        problems.add("walls", fmt::format("must have at most {} points together, found {}; leave out what is finer "
                                          "than a grain",
                                          most_wall_points, n_points));
    }
}

void check_deposit(const Scene<2>& scene, Problems& problems) {
    if (!scene.sample) {
        return;
    }
    const double most = most_grains(*scene.sample);
    if (!(most < most_deposited)) {
        problems.add("sample.profile",
                     fmt::format("must hold at most {:.0e} grains, found room for {:.2g} of the smallest radius, {} "
                                 "[m]; use larger grains or a smaller profile",
                                 most_deposited, most, scene.sample->radii.min));
    }
}

void check_steps(const Scene<2>& scene, Problems& problems) {
    for (const auto& stage : scene.stages) {
        const double time = stage.until ? stage.until->at_most : stage.duration;
        const double steps = time / stage.solver.h;
        if (!(steps <= most_steps)) {
            problems.add(fmt::format("stages.{}.{}", stage.name, stage.until ? "until.at_most" : "duration"),
                         fmt::format("must be at most 2^53 steps, found {} s with h {} s, {:.2g} steps; give a longer "
                                     "step or a shorter time",
                                     time, stage.solver.h, steps));
        }
    }
}

/// Grids over all grains: nothing is to be seen between two nodes that lie within a grain.
void check_grids(const Scene<2>& scene, double smallest_radius, Problems& problems) {
    constexpr double finest = 0.01; // of a radius
    const double least = finest * smallest_radius;
    const auto check = [&](const char* key, double value) {
        if (value > 0 && value < least) {
            problems.add(key,
                         fmt::format("must be at least a hundredth of the smallest radius ({:.6g} m), found {} [m]; "
                                     "a few radii are usual",
                                     least, value));
        }
    };
    check("output.front_bin", scene.output.front_bin);
    check("output.measures.spacing", scene.output.measures.spacing);
    check("output.measures.range", scene.output.measures.range);
}

} // namespace

void check_sizes(const Scene<2>& scene, double smallest_radius, Problems& problems) {
    check_points(scene, problems);
    check_deposit(scene, problems);
    check_steps(scene, problems);
    check_grids(scene, smallest_radius, problems);
}

} // namespace nappe::scene_file
