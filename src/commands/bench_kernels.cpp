#include "commands/bench_kernels.hpp"

#include "core/contact_geometry.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>

namespace nappe {

std::vector<const DiskKernels*> kernels_everywhere(const Communicator& comm) {
    constexpr std::array names = {"scalar", "portable", "avx2", "avx512"};
    std::array<const DiskKernels*, names.size()> here{};
    std::uint32_t missing = 0;
    for (std::size_t k = 0; k < names.size(); ++k) {
        try {
            here[k] = &disk_kernels(names[k]);
        } catch (const InputError&) {
            missing |= 1u << k;
        }
    }
    missing = comm.bit_or(missing);
    std::vector<const DiskKernels*> everywhere;
    for (std::size_t k = 0; k < names.size(); ++k) {
        if ((missing >> k & 1u) == 0) {
            everywhere.push_back(here[k]);
        }
    }
    return everywhere;
}

SweepProblem::SweepProblem(const Communicator& alone, const Simulation<2>& simulation)
    : settings_(simulation.settings()), halo_(alone), solver_(alone, watch_),
      contacts_(simulation.scene(), disk_kernels()), u_(simulation.state().u),
      mu_(PairLaws(simulation.scene()).uniform_friction) {
    const auto& state = simulation.state();
    const auto& g = simulation.scene().gravity;
    settings_.tolerance.reset();
    auto candidates = simulation.candidates(); // pack puts back what it replaces
    contacts_.pack(state, candidates, simulation.walls(), settings_.h, false);
    for (LocalId i = 0; i < state.n_held(); ++i) {
        u_[i].v[0] += settings_.h * g[0];
        u_[i].v[1] += settings_.h * g[1];
    }
    solver_.order_tiles(simulation.candidates());
    solver_.warm_start(contacts_, halo_, u_);
    make_list(simulation);
}

void SweepProblem::make_list(const Simulation<2>& simulation) {
    const auto& state = simulation.state();
    std::vector<LocalId> by_id(static_cast<std::size_t>(state.n_bodies()));
    std::iota(by_id.begin(), by_id.end(), 0);
    std::sort(by_id.begin(), by_id.begin() + state.n_held(),
              [&](LocalId i, LocalId k) { return state.id[i] < state.id[k]; });
    list_row_.resize(by_id.size());
    for (const LocalId body : by_id) {
        list_row_[body] = static_cast<LocalId>(list_u_.size());
        const auto& u = u_[body];
        list_u_.push_back({u.v[0], u.v[1], u.s[0], u.inv_m});
    }
    list_.reserve(static_cast<std::size_t>(contacts_.n_active()));
    for (std::size_t t = 0; t < contacts_.n_tiles(); ++t) {
        contacts_.for_each(t, [&](LocalId a, LocalId b, const Vec<2>& n, double r_n, double r_t) {
            const double gap = contact_geometry(state, simulation.walls(), a, b).gap;
            const double bias = gap > 0 ? gap / settings_.h : 0.0; // the bench's scene has no restitution
            list_.push_back(
                {n[0], n[1], bias, 1.0 / (u_[a].inv_m + u_[b].inv_m), r_n, r_t, list_row_[a], list_row_[b]});
        });
    }
    std::sort(list_.begin(), list_.end(),
              [](const auto& p, const auto& q) { return p.a != q.a ? p.a < q.a : p.b < q.b; });
}

std::int64_t SweepProblem::n_slots() const {
    std::int64_t batches = 0;
    for (std::size_t t = 0; t < contacts_.n_tiles(); ++t) {
        batches += contacts_.n_batches(t);
    }
    return batches * n_lanes;
}

void SweepProblem::sweep(const DiskKernels& kernels, int n) {
    contacts_.use(kernels);
    solver_.solve(contacts_, halo_, u_, settings_, n, 0.0);
}

void SweepProblem::sweep_list(int n) {
    for (int k = 0; k < n; ++k) {
        bench_loops().relax_list(list_.data(), static_cast<std::int64_t>(list_.size()), mu_, list_u_.data());
    }
}

const KernelFigures& KernelComparison::fastest() const {
    return *std::min_element(kernels.begin(), kernels.end(),
                             [](const auto& p, const auto& q) { return p.ns.median < q.ns.median; });
}

const KernelFigures* KernelComparison::find(const std::string& name) const {
    const auto it = std::find_if(kernels.begin(), kernels.end(), [&](const auto& k) { return k.name == name; });
    return it == kernels.end() ? nullptr : &*it;
}

namespace {

struct Contender {
    std::string name;
    std::function<void(int)> sweep;
    int sweeps = 1;           ///< in a turn
    std::vector<double> ns{}; ///< per relaxation, of every round
};

std::vector<Contender> contenders(const Communicator& comm, SweepProblem& problem) {
    std::vector<Contender> all;
    all.push_back({reference_name, [&problem](int n) { problem.sweep_list(n); }});
    for (const DiskKernels* kernels : kernels_everywhere(comm)) {
        all.push_back({kernels->name, [&problem, kernels](int n) { problem.sweep(*kernels, n); }});
    }
    return all;
}

/// Turns of all in rounds; ns of a turn by the slowest rank. @param contacts of this rank
void take_turns(const Communicator& comm, std::vector<Contender>& all, std::int64_t contacts,
                const ComparisonEffort& effort) {
    const auto timed = [&](const Contender& c, int sweeps) {
        comm.barrier();
        return seconds_of([&] { c.sweep(sweeps); });
    };
    for (auto& c : all) {
        timed(c, 1); // brings it into the caches
        const double once = std::max(comm.max(timed(c, 1)), 1e-9);
        // Some at least: a step does many, and several together use what one brought into the caches.
        constexpr double least = 8;
        c.sweeps = static_cast<int>(std::clamp(std::ceil(effort.seconds / once), least, 1e6));
    }
    for (int round = 0; round < effort.rounds; ++round) {
        for (auto& c : all) {
            const double t = timed(c, c.sweeps);
            const auto relaxed = static_cast<double>(contacts) * c.sweeps;
            c.ns.push_back(comm.max(contacts > 0 ? 1e9 * t / relaxed : 0.0));
        }
    }
}

std::vector<KernelFigures> figures_of(const std::vector<Contender>& kernels, const Contender& triad) {
    const auto median = [](const Contender& c) { return quartiles(c.ns).median; };
    const auto fastest = std::min_element(kernels.begin(), kernels.end(),
                                          [&](const auto& p, const auto& q) { return median(p) < median(q); });
    std::vector<KernelFigures> figures;
    figures.reserve(kernels.size());
    for (const auto& c : kernels) {
        figures.push_back({c.name, c.sweeps, quartiles(c.ns), quartiles(ratios(kernels.front().ns, c.ns)),
                           quartiles(ratios(c.ns, fastest->ns)), quartiles(ratios(c.ns, triad.ns))});
    }
    return figures;
}

} // namespace

KernelComparison compare_kernels(const Simulation<2>& simulation, const ComparisonEffort& effort) {
    const auto& comm = simulation.comm();
    const auto alone = Communicator::alone();
    SweepProblem problem(alone, simulation);
    Triad triad(bytes_per_contact_relaxed * problem.n_contacts() + bytes_per_grain_swept * simulation.state().n_own);
    KernelComparison result;
    result.triad = measure_triad(comm, triad, effort.triad_seconds);
    auto all = contenders(comm, problem);
    all.push_back({"triad", [&triad](int n) { triad.pass(n); }});
    take_turns(comm, all, problem.n_contacts(), effort);
    const auto of_triad = std::move(all.back());
    all.pop_back();
    result.kernels = figures_of(all, of_triad);
    result.contacts = comm.sum(problem.n_contacts());
    const auto slots = comm.sum(problem.n_slots());
    result.fill = slots > 0 ? static_cast<double>(result.contacts) / static_cast<double>(slots) : 0.0;
    return result;
}

} // namespace nappe
