#pragma once
// A step of a run, as preparation and loading take it: what the watch finds is shown, and a step that fails leaves a
// checkpoint.

#include "commands/checkpointer.hpp"
#include "io/progress.hpp"
#include "solver/simulation.hpp"

#include <cstdint>
#include <functional>

namespace nappe {

/// **Collective.** Throws what the step throws; a NumericalFailure after the state before the step has been kept, if it
/// can be and the run writes checkpoints.
/// @param keep writes a checkpoint of the present state; false: it can not
/// @returns what all ranks asked for (Checkpointer)
std::uint32_t watched_step(Simulation<2>& simulation, bool with_residual, Checkpointer& checkpointer,
                           Progress& progress, const std::function<bool()>& keep);

} // namespace nappe
