#include "commands/bench_smooth.hpp"

#include "solver/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <optional>

namespace nappe {

namespace {

constexpr double stiffness = 5e7; // N/m: a bed 30 m high presses its lowest disks together by about 1 % of their radius
constexpr double step = 1e-4;     // s, a fifth of what is known to be stable
constexpr int first_steps = 100;  // until contacts bear the weight

/// bench_scene on springs, in its only stage.
Scene<2> smooth_scene(double length) {
    auto scene = bench_scene(length);
    for (auto& law : scene.laws) {
        law.springs = Springs{{stiffness, {}}, {stiffness, {}}};
    }
    scene.materials[0].damping = 100;
    for (auto& stage : scene.stages) {
        stage.solver.method = SolverSettings::Method::cundall;
        stage.solver.theta = 1;
        stage.solver.h = step;
    }
    return scene;
}

/// The processor's, of this rank: a machine that others work on too counts less.
double processor_seconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Spent {
    double seconds = 0, processor = 0;
};

/// What so many steps took; `touched` counts the contacts in them.
Spent spent_on_steps(Simulation<2>& simulation, int steps, std::int64_t& touched) {
    const auto before = simulation.counters().relaxations;
    const double before_all = processor_seconds();
    const double seconds = seconds_of([&] {
        for (int k = 0; k < steps; ++k) {
            simulation.step();
        }
    });
    touched = simulation.counters().relaxations - before;
    return {seconds, processor_seconds() - before_all};
}

} // namespace

SmoothFigures measure_smooth(const Communicator& comm, const SettledBlock& block, std::int64_t grains, int rounds,
                             double seconds) {
    const auto copies = n_copies(block, grains);
    const auto scene = smooth_scene(static_cast<double>(copies) * block.length);
    const auto self = Communicator::alone();
    std::int64_t touched = 0;
    const auto warm_up = [&](Simulation<2>& simulation) {
        load_copies(simulation, block, copies);
        simulation.step();
        simulation.start_stage(0); // cuts tiles by what they cost
        return spent_on_steps(simulation, first_steps, touched).seconds / first_steps;
    };
    std::optional<Simulation<2>> alone;
    if (comm.size() > 1) {
        on_root_alone(comm, [&] { warm_up(alone.emplace(self, scene, disk_kernels())); });
    }
    Simulation<2> together(comm, scene, disk_kernels());
    const double once = comm.max(warm_up(together));

    SmoothFigures figures;
    figures.rounds = rounds;
    figures.steps = static_cast<int>(std::clamp(std::ceil(seconds / std::max(once, 1e-9)), 1.0, 1e6));
    figures.grains = together.domain().n_grains();
    std::vector<double> contact, grain, efficiency;
    for (int k = 0; k < rounds; ++k) {
        double mine = 0;
        if (comm.size() > 1) {
            on_root_alone(comm, [&] { mine = spent_on_steps(*alone, figures.steps, touched).seconds; });
            comm.barrier();
        }
        const Spent spent = spent_on_steps(together, figures.steps, touched);
        const double all = comm.max(spent.seconds) * comm.size();
        const double busy = comm.size() > 1 ? all : spent.processor; // ranks that wait are as busy as others
        const auto contacts = comm.sum(touched);
        figures.contacts = contacts / figures.steps;
        contact.push_back(1e9 * busy / static_cast<double>(std::max<std::int64_t>(1, contacts)));
        grain.push_back(1e9 * busy / (static_cast<double>(figures.grains) * figures.steps));
        efficiency.push_back(comm.max(mine) / all);
    }
    figures.contact_ns = quartiles(contact);
    figures.grain_ns = quartiles(grain);
    figures.best_contact_ns = *std::min_element(contact.begin(), contact.end());
    figures.efficiency = quartiles(efficiency);
    const auto hash = together.state_hash();
    figures.same_state = comm.bit_or(alone && alone->state_hash() != hash ? 1u : 0u) == 0;
    return figures;
}

BenchTable smooth_table(const std::vector<SmoothFigures>& sizes, int ranks) {
    std::vector<BenchTable::Column> columns = {{"grains", "grains"},           {"contacts", "contacts"},
                                               {"steps", "steps/round"},       {"contact_ns", "ns a contact", 2},
                                               {"contact_ns_low", "25 %", 2},  {"contact_ns_high", "75 %", 2},
                                               {"contact_ns_best", "best", 2}, {"grain_ns", "ns a grain", 2}};
    if (ranks > 1) {
        columns.insert(columns.end(), {{"efficiency", "efficiency", 3},
                                       {"efficiency_low", "25 %", 3},
                                       {"efficiency_high", "75 %", 3},
                                       {"same_state", "same state"}});
    }
    BenchTable table("smooth",
                     "Smooth contacts (Cundall), whole steps: ns per step and contact that overlaps, and per step and "
                     "grain, of one rank's time (alone: of its processor's); median, quartiles and\nbest of rounds. "
                     "Efficiency: rank 0 alone over "
                     "ranks times all of them, in turns.",
                     std::move(columns));
    for (const auto& s : sizes) {
        BenchTable::Row row = {s.grains,         s.contacts,        s.steps,           s.contact_ns.median,
                               s.contact_ns.low, s.contact_ns.high, s.best_contact_ns, s.grain_ns.median};
        if (ranks > 1) {
            row.insert(row.end(), {s.efficiency.median, s.efficiency.low, s.efficiency.high, s.same_state});
        }
        table.add(std::move(row));
    }
    return table;
}

} // namespace nappe
