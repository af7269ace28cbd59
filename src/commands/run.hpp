#pragma once
// `nappe run SCENE`: prepare, load, record.

#include "core/error.hpp"
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

} // namespace nappe
