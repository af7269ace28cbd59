#include "commands/bench_steps.hpp"

#include <algorithm>
#include <numeric>

namespace nappe {

namespace {

double total(const std::vector<double>& of_ranks) {
    return std::accumulate(of_ranks.begin(), of_ranks.end(), 0.0);
}

} // namespace

StepFigures measure_steps(Simulation<2>& simulation, BenchStage stage, int steps) {
    const auto& comm = simulation.comm();
    simulation.start_stage(static_cast<int>(stage));
    simulation.step();
    simulation.watch().clear();
    const auto before = simulation.counters();
    comm.barrier();
    const double elapsed = seconds_of([&] {
        for (int k = 0; k < steps; ++k) {
            simulation.step();
        }
    });
    const auto& after = simulation.counters();
    const auto seconds = simulation.watch().seconds();

    StepFigures figures;
    figures.sweeps = simulation.settings().sweeps;
    figures.steps = steps;
    figures.step_ms = 1e3 * comm.max(elapsed) / steps;
    std::array<double, n_timed> of_all{};
    for (std::size_t k = 0; k < n_timed; ++k) {
        of_all[k] = total(comm.all_gather(std::vector<double>{seconds[k]}));
        figures.ms[k] = 1e3 * of_all[k] / (steps * comm.size());
    }
    constexpr auto sweep = static_cast<std::size_t>(Timed::sweep), exchange = static_cast<std::size_t>(Timed::exchange);
    figures.ms[sweep] -= figures.ms[exchange]; // the one goes on inside the other
    const double whole = total(comm.all_gather(std::vector<double>{elapsed}));
    figures.other_share = 1 - of_all[sweep] / whole;
    figures.exchange_share = of_all[sweep] > 0 ? of_all[exchange] / of_all[sweep] : 0.0;
    const auto mine = after.relaxations - before.relaxations;
    const auto all = comm.sum(mine);
    figures.imbalance =
        all > 0 ? static_cast<double>(comm.max(mine)) * comm.size() / static_cast<double>(all) - 1 : 0.0;
    figures.rebuilds = after.rebuilds - before.rebuilds;
    figures.redone = after.redone_lists + after.redone_packs - before.redone_lists - before.redone_packs;
    return figures;
}

Quartiles measure_rebuild(Simulation<2>& simulation, int times) {
    const auto& comm = simulation.comm();
    const double per_grain = 1e9 * comm.size() / static_cast<double>(simulation.domain().n_grains());
    std::vector<double> ns;
    for (int k = 0; k < times; ++k) {
        simulation.watch().clear();
        comm.barrier();
        simulation.start_stage(simulation.stage());
        ns.push_back(per_grain * comm.max(simulation.watch().seconds()[static_cast<std::size_t>(Timed::rebuild)]));
    }
    return quartiles(ns);
}

ResidentSet resident_of_all(const Communicator& comm) {
    const auto mine = resident_set();
    return {comm.sum(mine.now), comm.sum(mine.highest)};
}

} // namespace nappe
