#include "commands/trade.hpp"

#include "commands/run.hpp"
#include "commands/signals.hpp"
#include "commands/trade_plan.hpp"
#include "commands/trade_report.hpp"
#include "io/atomic_file.hpp"
#include "io/folder_lock.hpp"
#include "io/scene_reader.hpp"
#include "io/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <numeric>

namespace nappe {

namespace {

/// **Collective.** f() on the root; its InputError or SystemError is thrown on all ranks.
template <class F>
void on_root(const Communicator& comm, F&& f) {
    std::string input, system;
    if (comm.is_root()) {
        try {
            f();
        } catch (const InputError& e) {
            input = e.what();
        } catch (const SystemError& e) {
            system = e.what();
        }
    }
    comm.throw_together<InputError>(input);
    comm.throw_together<SystemError>(system);
}

TradeMatrix shared_matrix(const Communicator& comm, const TradeOptions& options) {
    const auto text =
        options.matrix.empty() ? std::string(default_matrix()) : shared_text(comm, options.matrix, read_matrix_text);
    auto matrix = parse_matrix(text, options.matrix.empty() ? "the default matrix" : options.matrix);
    if (options.seeds) {
        matrix.seeds.resize(static_cast<std::size_t>(*options.seeds));
        std::iota(matrix.seeds.begin(), matrix.seeds.end(), 1);
    }
    return matrix;
}

/// **Collective.** Looks at all folders before anything is run: a conflict shows at once.
std::string shared_states(const Communicator& comm, const TradePlan& plan) {
    std::string states;
    on_root(comm, [&] {
        for (const auto& run : plan.runs) {
            states += static_cast<char>(state_of(run));
        }
    });
    comm.broadcast(states);
    return states;
}

std::string line_of(const TradePlan& plan, const PlannedRun& run, double window) {
    const auto f = read_run(run.folder, run.scene, window).figures;
    return fmt::format(
        "{}, seed {}: {:.3g} relaxations in {:.1f} s; residual {:.2g}, overlap {:.2g} r, largest {:.2g} r",
        plan.names[run.setting], plan.seeds[run.seed], f.relaxations, f.seconds_loading, f.residual, f.overlap_mean,
        f.overlap_max_of_rows);
}

/// **Collective.** One run, in silence.
RunState make_run(const Communicator& comm, const PlannedRun& run, const TradeOptions& options) {
    RunOptions run_options;
    run_options.out = run.folder;
    run_options.samples = options.samples;
    run_options.steps = run.steps;
    run_options.checkpoints.policy = {0, 0}; // what is not finished is run again
    Progress::Settings silence;
    silence.enabled = false;
    Progress silent(silence);
    try {
        const auto code = run_scene(comm, run.scene, run_options, silent);
        return code == ExitCode::done ? RunState::done : RunState::to_do;
    } catch (const NumericalFailure& e) { // thrown by all ranks alike
        on_root(comm, [&] { remember_failure(run, e.what()); });
        return RunState::failed;
    }
}

/// **Collective.** Runs what is missing. @returns false after a signal
bool make_missing_runs(const Communicator& comm, const TradePlan& plan, const TradeOptions& options, double window,
                       std::string& states) {
    Progress progress(Progress::for_rank(comm.is_root()));
    const auto n = plan.runs.size();
    std::size_t done =
        n - static_cast<std::size_t>(std::count(states.begin(), states.end(), static_cast<char>(RunState::to_do)));
    progress.info(fmt::format("{} settings and the reference, {} seeds: {} of {} runs are done", plan.names.size() - 1,
                              plan.seeds.size(), done, n));
    for (std::size_t k = 0; k < n; ++k) {
        if (states[k] != static_cast<char>(RunState::to_do)) {
            continue;
        }
        if (stop_asked(comm)) {
            return false;
        }
        const auto state = make_run(comm, plan.runs[k], options);
        states[k] = static_cast<char>(state);
        if (state == RunState::to_do) {
            return false;
        }
        ++done;
        on_root(comm, [&] {
            const auto& run = plan.runs[k];
            const auto said = state == RunState::done ? line_of(plan, run, window)
                                                      : fmt::format("{}, seed {}: failed: {}", plan.names[run.setting],
                                                                    plan.seeds[run.seed], failure_of(run));
            progress.info(fmt::format("[{}/{}] {}", done, n, said));
        });
    }
    return true;
}

/// Local, for rank 0.
void report(const TradePlan& plan, const TradeMatrix& matrix, const std::string& states, const TradeOptions& options) {
    std::vector<TradeResult> results;
    for (std::size_t k = 0; k < plan.runs.size(); ++k) {
        const auto& run = plan.runs[k];
        if (states[k] == static_cast<char>(RunState::done)) {
            results.push_back({run.setting, run.seed, read_run(run.folder, run.scene, matrix.window), ""});
        } else if (states[k] == static_cast<char>(RunState::failed)) {
            results.push_back({run.setting, run.seed, std::nullopt, failure_of(run)});
        }
    }
    const auto rows = trade_rows(plan, results);
    const auto n_seeds = plan.seeds.size();
    write_file_atomically(options.out / "trade.csv", trade_csv(rows, n_seeds));
    write_file_atomically(options.out / "observables.csv", observables_csv(rows));
    write_summary(options.out / "trade.json", trade_json(plan, matrix, results, rows));
    fmt::print("{}", trade_text(rows, n_seeds));
    std::fflush(stdout);
}

} // namespace

ExitCode trade(const Communicator& comm, const TradeOptions& options) {
    const auto text = shared_text(comm, options.scene, read_scene_text);
    const auto matrix = shared_matrix(comm, options);
    // Every rank finds the same errors.
    const auto plan = plan_trade(text, options.scene, options.overrides, matrix, options.out);
    const FolderLock lock(comm, options.out);
    auto states = shared_states(comm, plan);
    catch_signals();
    const bool whole = make_missing_runs(comm, plan, options, matrix.window, states);
    on_root(comm, [&] {
        if (states.find(static_cast<char>(RunState::done)) != std::string::npos ||
            states.find(static_cast<char>(RunState::failed)) != std::string::npos) {
            report(plan, matrix, states, options);
        }
        if (!whole) {
            fmt::print("stopped by a signal; the same command again runs what is missing\n");
        }
    });
    return whole ? ExitCode::done : ExitCode::stopped_early;
}

} // namespace nappe
