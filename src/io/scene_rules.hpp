#pragma once
// The rules that look at more than one key of a scene: laws for every pair, geometry, tiles. Internal to src/io.

#include "core/scene.hpp"
#include "io/scene_table.hpp"

namespace nappe::scene_file {

/// Adds every rule that a scene, whole in each of its sections, still breaks. Local.
void check_rules(const Scene<2>& scene, Problems& problems);

/// Local. Whether tiles are wide enough, and whether what the scene asks for goes with its large grains.
void check_tiles(const Scene<2>& scene, Problems& problems);

/// Part of it (io/scene_sizes.cpp): how much a scene may ask for. Local.
/// @param smallest_radius of all grains [m]
void check_sizes(const Scene<2>& scene, double smallest_radius, Problems& problems);

} // namespace nappe::scene_file
