#pragma once
// What a step of smooth contacts costs, all that belongs to it included, and how much of that several ranks save.

#include "commands/bench_sample.hpp"
#include "commands/bench_statistics.hpp"
#include "commands/bench_table.hpp"

#include <vector>

namespace nappe {

struct SmoothFigures {
    std::int64_t grains = 0, contacts = 0; ///< contacts: that overlap, mean of the steps
    int rounds = 0, steps = 0;             ///< of each round
    Quartiles contact_ns, grain_ns;        ///< of a step: time of the slowest rank x ranks / contacts, / grains
    double best_contact_ns = 0;
    Quartiles efficiency;   ///< with several ranks: of rank 0 alone / (ranks x of all), round by round
    bool same_state = true; ///< both ended in the same state, bit for bit
};

/// **Collective.** Whole steps of a settled pile on springs, in rounds of `seconds` at least; with several ranks rank 0
/// alone and all take turns.
SmoothFigures measure_smooth(const Communicator& comm, const SettledBlock& block, std::int64_t grains, int rounds,
                             double seconds);

BenchTable smooth_table(const std::vector<SmoothFigures>& sizes, int ranks);

} // namespace nappe
