#pragma once
// What a whole step costs by stage, what a rebuild costs, what a sample takes of memory.

#include "commands/bench_memory.hpp"
#include "commands/bench_sample.hpp"
#include "commands/bench_statistics.hpp"

#include <array>

namespace nappe {

/// Of some steps in a row, means over steps and ranks.
struct StepFigures {
    int sweeps = 0; ///< of a step
    int steps = 0;
    double step_ms = 0;               ///< of the slowest rank
    std::array<double, n_timed> ms{}; ///< by stage; `sweep` without the exchange inside it
    double other_share = 0;           ///< of a step: all but sweeps and exchange
    double exchange_share = 0;        ///< of a sweep: packing and exposed waiting
    double imbalance = 0;             ///< of relaxations over ranks: largest / mean - 1
    std::int64_t rebuilds = 0, redone = 0;
};

/// **Collective.** Starts the stage anew, which balances and rebuilds, and times `steps` steps after one that is not.
StepFigures measure_steps(Simulation<2>& simulation, BenchStage stage, int steps);

/// **Collective.** Time of a rebuild per grain and rank [ns]: seconds of the slowest rank x ranks / grains.
Quartiles measure_rebuild(Simulation<2>& simulation, int times);

/// Bytes of all ranks together.
struct MemoryFigures {
    std::int64_t before = 0;  ///< resident before there was a sample
    std::int64_t steady = 0;  ///< resident between two steps
    std::int64_t highest = 0; ///< resident at any time since `before`, loading included
    double budget = 0;        ///< for the sample: 250 a grain and 120 a contact
};

/// **Collective.** Resident now and at most, of all ranks.
ResidentSet resident_of_all(const Communicator& comm);

} // namespace nappe
