#pragma once
// `nappe trade SCENE`: a matrix of solver settings run from the same initial states, compared with a reference far
// tighter than all (docs/accuracy.md).

#include "core/error.hpp"
#include "parallel/communicator.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace nappe {

struct TradeOptions {
    std::string scene;
    std::vector<std::string> overrides; ///< of the scene, for all runs
    std::string matrix;                 ///< file; empty: the one that the program brings along
    std::filesystem::path out;          ///< DIR
    std::filesystem::path samples;      ///< where settled samples are kept
    std::optional<int> seeds;           ///< 1 to this, in place of the matrix's
};

/// The text of jobs/trade-default.toml when the program was built. Local.
std::string_view default_matrix();

/// **Collective.** Runs what is missing of the matrix, one line a run; then the tables. A run that fails is a row that
/// says so. After a signal the tables are of what is there. Throws InputError, SystemError on all ranks alike.
/// @returns done, or stopped_early after a signal.
ExitCode trade(const Communicator& comm, const TradeOptions& options);

} // namespace nappe
