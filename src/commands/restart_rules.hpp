#pragma once
// What may be another in a scene when a run goes on from a checkpoint. Everything here is Local.

#include "core/scene.hpp"
#include "core/snapshot.hpp"

#include <cstdint>
#include <string>

namespace nappe {

/// Of all that a restart can not change: grains, walls, materials, tiles, cells, stages.
std::uint64_t restart_key(const Scene<2>& scene);

/// Throws InputError if `now` differs from `before` in anything that the state at `clock` depends on: what restart_key
/// takes in, stages that are over, and the step of the stage in hand.
void check_restart(const Scene<2>& before, const Scene<2>& now, const SnapshotClock& clock);

} // namespace nappe
