#pragma once
// The grains of a scene before anything has moved.

#include "core/rows.hpp"
#include "core/scene.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace nappe {

/// Local. The sample's deposit, then the single grains that are not to be dropped, ids 0 … n-1 in that order. InputError:
/// see deposit.
std::vector<GrainRow<2>> initial_grains(const Scene<2>& scene);

/// Local. A single grain where the scene has it.
GrainRow<2> single_grain(const Scene<2>& scene, const SingleGrain<2>& single, GlobalId id);

/// Local. How many grains the scene will have, those that are dropped with them, where that is known before they are made:
/// in all scenes but those with a deposit. Pre: a lattice that lattice_fault finds nothing wrong with.
std::optional<std::int64_t> known_size(const Scene<2>& scene);

/// Local. "must …, found …; …" of a probe whose grain is not among n; empty if it is.
std::string probe_fault(const Probe& probe, std::int64_t n);

} // namespace nappe
