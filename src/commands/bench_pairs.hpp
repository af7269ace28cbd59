#pragma once
// One rank against all ranks: the same sample, the same steps, in turns.

#include "commands/bench_sample.hpp"
#include "commands/bench_statistics.hpp"

namespace nappe {

struct PairFigures {
    std::int64_t grains = 0, contacts = 0;
    int pairs = 0;
    int steps = 0;          ///< of each turn, with 100 sweeps each
    Quartiles one_ns;       ///< per relaxation, one rank
    Quartiles all_ns;       ///< the same with all ranks: time of the slowest / relaxations of all
    Quartiles speedup;      ///< one over the other, pair by pair
    bool same_state = true; ///< both ended in the same state, bit for bit
};

/// **Collective.** Times the sweeps, exchange included, in alternating turns of `seconds` at least: rank 0 alone while
/// the others sleep, then all ranks.
PairFigures measure_pairs(const Communicator& comm, const SettledBlock& block, std::int64_t grains, int pairs,
                          double seconds);

} // namespace nappe
