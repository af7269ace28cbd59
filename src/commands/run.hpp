#pragma once
// `nappe run SCENE` and `nappe restart DIR`: prepare, load, record; from the start or from a checkpoint.

#include "commands/checkpointer.hpp"
#include "core/error.hpp"
#include "core/scene.hpp"
#include "io/progress.hpp"
#include "parallel/communicator.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace nappe {

class FolderLock;
class Progress;

struct RunOptions {
    std::string scene;
    std::vector<std::string> overrides;
    std::filesystem::path out;         ///< DIR
    std::filesystem::path samples;     ///< where settled samples are kept
    std::optional<std::int64_t> steps; ///< of loading, at most
    std::string kernel;                ///< instruction set; empty: the fastest
    CheckpointSettings checkpoints;
    bool overwrite = false; ///< begin anew where an unfinished run lies
};

/// **Collective.** Throws InputError, NumericalFailure, SystemError on all ranks alike.
/// @returns done, or stopped_early after a signal or at the end of its wall time.
ExitCode run(const Communicator& comm, const RunOptions& options);

/// **Collective.** Goes on in options.out from its newest good checkpoint, with options.overrides over the scene as run;
/// options.scene and options.overwrite have no part in it. As `run`; InputError if there is no good checkpoint.
ExitCode restart(const Communicator& comm, RunOptions options);

/// On the root. Where the file system has no locks, the user must see to it that a folder has one run.
void warn_without_lock(const FolderLock& lock, const std::filesystem::path& folder, Progress& progress);

/// **Collective.** A scene that is read already, the same on all ranks: options.scene and options.overrides have no part
/// in it. @param from where to go on from, nullptr: from the start. Pre: the caller holds the folder's lock.
ExitCode run_scene(const Communicator& comm, const Scene<2>& scene, const RunOptions& options, Progress& progress,
                   const Checkpoint<2>* from = nullptr);

/// **Collective.** What read(path) gives on the root. Throws its InputError on all ranks.
std::string shared_text(const Communicator& comm, const std::string& path, std::string (*read)(const std::string&));

} // namespace nappe
