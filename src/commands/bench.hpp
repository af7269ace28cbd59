#pragma once
// `nappe bench`: what this machine allows and what nappe makes of it, in one run: bandwidth and the roofline it
// implies, kernels, steps, rebuilds, memory; or, with pairs, one rank against all; or what each feature of a scene adds.

#include "core/error.hpp"
#include "parallel/communicator.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace nappe {

struct BenchOptions {
    std::string grains;         ///< sizes, by commas; empty: the default of what is measured
    std::filesystem::path json; ///< FILE; empty: none
    int pairs = 0;              ///< turns of one rank against all; 0: everything else instead
    bool features = false;      ///< what each feature of a scene adds, instead of everything else
    bool smooth = false;        ///< what a step of smooth contacts costs, instead of everything else
    bool quick = false;         ///< one small size and few rounds: that it works, not how fast it is
};

/// Local. Sizes out of "3000,10000", in that order. Throws InputError.
std::vector<std::int64_t> parse_sizes(std::string_view text);

/// **Collective.** Prints tables on rank 0. Throws InputError, NumericalFailure, SystemError on all ranks alike.
ExitCode bench(const Communicator& comm, const BenchOptions& options);

} // namespace nappe
