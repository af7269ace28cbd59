#pragma once
// `nappe run SCENE`: prepare, load, record.

#include "core/error.hpp"
#include "core/scene.hpp"
#include "io/progress.hpp"
#include "parallel/communicator.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace nappe {

struct RunOptions {
    std::string scene;
    std::vector<std::string> overrides;
    std::filesystem::path out;         ///< DIR
    std::filesystem::path samples;     ///< where settled samples are kept
    std::optional<std::int64_t> steps; ///< of loading, at most
    std::string kernel;                ///< instruction set; empty: the fastest
};

/// **Collective.** Throws InputError, NumericalFailure, SystemError on all ranks alike.
/// @returns done, or stopped_early after a signal.
ExitCode run(const Communicator& comm, const RunOptions& options);

/// **Collective.** The same of a scene that is read already, the same on all ranks: options.scene and
/// options.overrides have no part in it.
ExitCode run_scene(const Communicator& comm, const Scene<2>& scene, const RunOptions& options, Progress& progress);

/// **Local.** From here on a signal to stop (USR1, USR2, TERM, INT) ends a run after the step in hand, on all ranks at
/// the same one; a second one ends the process at once.
void catch_signals();

/// **Collective.** Whether such a signal has come to any rank.
bool stop_asked(const Communicator& comm);

/// **Collective.** What read(path) gives on the root. Throws its InputError on all ranks.
std::string shared_text(const Communicator& comm, const std::string& path, std::string (*read)(const std::string&));

} // namespace nappe
