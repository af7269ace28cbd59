#pragma once
// The grains of a scene before anything has moved.

#include "core/rows.hpp"
#include "core/scene.hpp"

#include <vector>

namespace nappe {

/// Local. The sample's deposit, then the single grains that are not to be dropped, ids 0 … n-1 in that order. InputError:
/// see deposit.
std::vector<GrainRow<2>> initial_grains(const Scene<2>& scene);

/// Local. A single grain where the scene has it.
GrainRow<2> single_grain(const Scene<2>& scene, const SingleGrain<2>& single, GlobalId id);

} // namespace nappe
