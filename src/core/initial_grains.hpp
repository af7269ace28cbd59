#pragma once
// The grains of a scene before anything has moved.

#include "core/rows.hpp"
#include "core/scene.hpp"

#include <vector>

namespace nappe {

/// Local. The sample's deposit, then the single grains, ids 0 … n-1 in that order. InputError: see deposit.
std::vector<GrainRow<2>> initial_grains(const Scene<2>& scene);

} // namespace nappe
