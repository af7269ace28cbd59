#pragma once
// `nappe partitions SCENE`: how the scene would be cut for many ranks, and what each would compute and send in a sweep.
// docs/scaling.md turns these counts into times.

#include "core/scene.hpp"
#include "parallel/communicator.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace nappe {

struct PartitionsOptions {
    std::string scene;
    std::vector<std::string> overrides;
    std::vector<std::int32_t> parts = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096};
    double scale = 1;              ///< of the sample's profile and the walls' points
    double tile_scale = 0;         ///< of the profile once more, counted by tiles only; 0: not asked for
    std::filesystem::path samples; ///< a store with the settled sample; empty: the deposit as it is
    std::filesystem::path json;    ///< where all counts go; empty: nowhere
};

/// Profile and walls, `scale` times as large about the point (0, 0); everything else, radii above all, stays. Local.
Scene<2> scaled(Scene<2> scene, double scale);

/// Prints a table per kind of count; writes the counts of every part and every message as JSON. For one rank: there is
/// nothing to share out. Throws InputError, SystemError.
void partitions(const Communicator& comm, const PartitionsOptions& options);

} // namespace nappe
