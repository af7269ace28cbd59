#pragma once
// Grains that come when loading starts (`drop` of [[grains]]): put where they first touch what has settled.

#include "core/rows.hpp"
#include "core/scene.hpp"
#include "parallel/communicator.hpp"

#include <vector>

namespace nappe {

/// **Collective.** The grains of a sample, on whatever ranks, and the scene's grains to be dropped, on the root: each goes
/// from its position along gravity until it touches a grain of the sample or one dropped before it. InputError on all
/// ranks if there is none below, or if it starts inside of one.
std::vector<GrainRow<2>> with_dropped(const Communicator& comm, const Scene<2>& scene, std::vector<GrainRow<2>> grains);

/// Local. How many these are.
std::int64_t n_dropped(const Scene<2>& scene);

} // namespace nappe
