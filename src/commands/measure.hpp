#pragma once
// `nappe measure DIR`: the measures of a run, from its stored frames.

#include "core/error.hpp"
#include "parallel/communicator.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace nappe {

struct MeasureOptions {
    std::filesystem::path run;          ///< DIR, what `nappe run` wrote
    std::filesystem::path out;          ///< for the measures; empty: DIR/measures
    std::vector<std::string> overrides; ///< of output.measures and output.zone only: the rest is what was run
};

/// **Collective.** Reads the frames of the run one after the other. Throws InputError, SystemError on all ranks alike.
ExitCode measure(const Communicator& comm, const MeasureOptions& options);

} // namespace nappe
