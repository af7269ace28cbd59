#pragma once
// From a scene to the state in which loading starts: deposit, settling stages, and the store in which a settled sample
// waits for the next run that wants the same one.

#include "io/progress.hpp"
#include "io/sample_store.hpp"
#include "solver/simulation.hpp"

#include <filesystem>
#include <string>

namespace nappe {

/// Everything of a scene that its settled sample depends on, in one canonical text. Local.
/// @param n_ranks those it is made on: part of the text if the sample depends on it (solver.coupling)
SampleOrigin sample_origin(const Scene<2>& scene, int n_ranks = 1);

struct Preparation {
    bool reused = false;           ///< the sample came from the store
    std::int64_t settle_steps = 0; ///< of the stages that were run now
    double deposit_seconds = 0;
    double settle_seconds = 0;
};

/// **Collective.** Loads the simulation with the state at the end of its settling stages. A sample made now goes
/// through the store and back, so that it is the same bits as one found there. Throws what the steps throw;
/// NumericalFailure if a stage does not settle.
Preparation prepare(Simulation<2>& simulation, const std::filesystem::path& store, Progress& progress,
                    const volatile int& stop_signal);

/// Stopped by a signal while preparing. Exit code 3.
struct StoppedEarly {};

} // namespace nappe
