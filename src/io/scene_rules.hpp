#pragma once
// The rules that look at more than one key of a scene: laws for every pair, geometry, tiles. Internal to src/io.

#include "core/scene.hpp"
#include "io/scene_table.hpp"

namespace nappe::scene_file {

/// Adds every rule that a scene, whole in each of its sections, still breaks. Local.
void check_rules(const Scene<2>& scene, Problems& problems);

} // namespace nappe::scene_file
