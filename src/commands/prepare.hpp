#pragma once
// From a scene to the state in which loading starts: deposit, settling stages, and the store in which a settled sample
// waits for the next run that wants the same one.

#include "commands/checkpointer.hpp"
#include "io/progress.hpp"
#include "io/sample_store.hpp"
#include "solver/simulation.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <functional>
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

nlohmann::ordered_json to_json(const Preparation& preparation);
Preparation preparation_from(const nlohmann::ordered_json& json);

/// **Collective.** Loads the simulation with the state at the end of its settling stages. A sample made now goes
/// through the store and back, so that it is the same bits as one found there. Throws what the steps throw;
/// NumericalFailure if a stage does not settle; StoppedEarly after a checkpoint, unless the run writes none.
/// @param course of a checkpoint taken here, which the simulation has been resumed from; nullptr: from the start
/// @param remember(course) completes what a checkpoint taken here holds
Preparation prepare(Simulation<2>& simulation, const std::filesystem::path& store, Progress& progress,
                    Checkpointer& checkpointer, const nlohmann::ordered_json* course,
                    const std::function<void(nlohmann::ordered_json&)>& remember);

/// Stopped while preparing. Exit code 3.
struct StoppedEarly {
    bool kept = false; ///< there is a checkpoint of it
};

} // namespace nappe
