#include "commands/bench_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace nappe {

namespace {

/// Seconds that this rank spent on the sweeps of so many steps.
double swept(Simulation<2>& simulation, int steps) {
    simulation.watch().clear();
    for (int k = 0; k < steps; ++k) {
        simulation.step();
    }
    return simulation.watch().seconds()[static_cast<std::size_t>(Timed::sweep)];
}

/// To the state in which turns begin, tiles balanced by what they cost.
double warm_up(Simulation<2>& simulation, const SettledBlock& block, std::int64_t copies) {
    load_copies(simulation, block, copies);
    simulation.step();
    simulation.start_stage(static_cast<int>(BenchStage::sweeps_100));
    return swept(simulation, 1);
}

} // namespace

PairFigures measure_pairs(const Communicator& comm, const SettledBlock& block, std::int64_t grains, int pairs,
                          double seconds) {
    const auto copies = n_copies(block, grains);
    const auto scene = bench_scene(static_cast<double>(copies) * block.length);
    const auto self = Communicator::alone();
    std::optional<Simulation<2>> alone;
    double once = 0;
    on_root_alone(comm, [&] {
        alone.emplace(self, scene, disk_kernels());
        once = warm_up(*alone, block, copies);
    });
    Simulation<2> together(comm, scene, disk_kernels());
    warm_up(together, block, copies);

    PairFigures figures;
    figures.grains = together.domain().n_grains();
    figures.contacts = comm.sum(together.contacts().n_active());
    figures.pairs = pairs;
    figures.steps = static_cast<int>(std::clamp(std::ceil(seconds / std::max(comm.max(once), 1e-9)), 1.0, 1000.0));
    std::vector<double> one, all;
    for (int k = 0; k < pairs; ++k) {
        double mine = 0;
        std::int64_t relaxed = 0;
        on_root_alone(comm, [&] {
            const auto before = alone->counters().relaxations;
            mine = swept(*alone, figures.steps);
            relaxed = alone->counters().relaxations - before;
        });
        const double per_relaxation = 1e9 / static_cast<double>(std::max<std::int64_t>(1, comm.sum(relaxed)));
        one.push_back(per_relaxation * comm.max(mine));
        comm.barrier();
        all.push_back(per_relaxation * comm.max(swept(together, figures.steps)));
    }
    figures.one_ns = quartiles(one);
    figures.all_ns = quartiles(all);
    figures.speedup = quartiles(ratios(one, all));
    const auto hash = together.state_hash();
    figures.same_state = comm.bit_or(alone && alone->state_hash() != hash ? 1u : 0u) == 0;
    return figures;
}

} // namespace nappe
