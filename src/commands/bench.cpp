#include "commands/bench.hpp"

#include "commands/bench_machine.hpp"
#include "commands/bench_report.hpp"
#include "commands/bench_smooth.hpp"
#include "io/progress.hpp"
#include "io/summary.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cstdio>

namespace nappe {

namespace {

constexpr const char* default_sizes = "3000,10000,43000,172000,688000,2700000";
constexpr const char* default_pair_sizes = "10000,43000";
constexpr const char* default_feature_sizes = "43000";
constexpr const char* default_smooth_sizes = "3000,10000,43000,100000,1000000";
constexpr std::int64_t most_grains = 100'000'000;

/// How long to measure: enough for medians, little enough for minutes in all.
struct Effort {
    int settle_steps = 200;
    int steps = 10;   ///< that are timed
    int rebuilds = 7; ///< that are timed
    ComparisonEffort kernels;
};

Effort effort_for(std::int64_t grains, bool quick) {
    Effort effort;
    if (quick) {
        return {50, 2, 2, {3, 0.002, 0.02}};
    }
    if (grains > 50'000) {
        effort.steps = grains > 1'000'000 ? 2 : 4;
        effort.kernels.rounds = grains > 1'000'000 ? 5 : 7;
        effort.rebuilds = 3;
    }
    return effort;
}

/// Everything printed, also as JSON.
class BenchOutput {
public:
    BenchOutput(const Communicator& comm, const BenchOptions& options, nlohmann::ordered_json machine)
        : comm_(comm), path_(options.json) {
        json_["version"] = program_version();
        json_["quick"] = options.quick;
        json_["machine"] = std::move(machine);
        // Now too, and after every size: a file that can not be written is known before minutes are spent, and a run
        // that is stopped leaves what it has.
        save();
        print("Machine and build\n");
        for (const auto& [key, value] : json_["machine"].items()) {
            print(fmt::format("  {:<20} {}\n", key, value.is_string() ? value.get<std::string>() : value.dump()));
        }
        print("\n");
    }

    /// Into the JSON; printed at the end only, a table for all sizes.
    void take(const std::vector<BenchTable>& tables, bool last) {
        for (const auto& table : tables) {
            if (!table.empty()) {
                json_[table.key()] = table.json();
                print(last ? table.text() : "");
            }
        }
        save();
    }

    /// **Collective.** Throws SystemError.
    void save() {
        std::string error;
        if (comm_.is_root() && !path_.empty()) {
            try {
                write_summary(path_, json_);
            } catch (const SystemError& e) {
                error = e.what();
            }
        }
        comm_.throw_together<SystemError>(error);
    }

private:
    void print(const std::string& text) const {
        if (comm_.is_root()) {
            std::fputs(text.c_str(), stdout);
            std::fflush(stdout);
        }
    }

    const Communicator& comm_;
    std::filesystem::path path_;
    nlohmann::ordered_json json_;
};

nlohmann::ordered_json machine_of(const Communicator& comm) {
    std::vector<std::string> kernels;
    for (const auto* set : kernels_everywhere(comm)) {
        kernels.emplace_back(set->name);
    }
    return describe_machine(comm.size(), kernels);
}

SizeFigures measure_size(const Communicator& comm, const SettledBlock& block, std::int64_t grains,
                         const Effort& effort) {
    SizeFigures figures;
    return_free_memory();
    forget_highest();
    figures.memory.before = resident_of_all(comm).now;

    const auto copies = n_copies(block, grains);
    Simulation<2> simulation(comm, bench_scene(static_cast<double>(copies) * block.length), disk_kernels());
    load_copies(simulation, block, copies);
    simulation.step(); // counts the work by which tiles are balanced
    figures.at_10 = measure_steps(simulation, BenchStage::sweeps_10, effort.steps);
    figures.at_100 = measure_steps(simulation, BenchStage::sweeps_100, effort.steps);
    figures.grains = simulation.domain().n_grains();
    const auto resident = resident_of_all(comm);
    figures.memory.steady = resident.now;
    figures.memory.highest = resident.highest;

    figures.rebuild_ns = measure_rebuild(simulation, effort.rebuilds);
    simulation.step();
    figures.kernels = compare_kernels(simulation, effort.kernels);
    figures.contacts = figures.kernels.contacts;
    figures.memory.budget = 250 * static_cast<double>(figures.grains) + 120 * static_cast<double>(figures.contacts);
    return figures;
}

void measure_sizes(const Communicator& comm, const BenchOptions& options, Progress& progress, BenchOutput& output) {
    const auto sizes =
        parse_sizes(!options.grains.empty() ? options.grains.c_str() : (options.quick ? "3000" : default_sizes));
    const auto block =
        settle_block(Communicator::alone(), block_grains, effort_for(block_grains, options.quick).settle_steps);
    std::vector<SizeFigures> figures;
    for (const auto grains : sizes) {
        progress.info(fmt::format("bench: {} grains", grains));
        figures.push_back(measure_size(comm, block, grains, effort_for(grains, options.quick)));
        std::vector<BenchTable> tables = {bandwidth_table(figures), kernel_table(figures), step_table(figures)};
        if (comm.size() > 1) {
            tables.push_back(exchange_table(figures));
        }
        tables.push_back(memory_table(figures));
        tables.push_back(asked_table(figures, comm.size()));
        output.take(tables, figures.size() == sizes.size());
    }
}

void measure_all_pairs(const Communicator& comm, const BenchOptions& options, Progress& progress, BenchOutput& output) {
    const auto sizes =
        parse_sizes(!options.grains.empty() ? options.grains.c_str() : (options.quick ? "3000" : default_pair_sizes));
    const auto block =
        settle_block(Communicator::alone(), block_grains, effort_for(block_grains, options.quick).settle_steps);
    std::vector<PairFigures> figures;
    for (const auto grains : sizes) {
        progress.info(fmt::format("bench: {} pairs at {} grains", options.pairs, grains));
        figures.push_back(measure_pairs(comm, block, grains, options.pairs, options.quick ? 0.005 : 0.2));
        output.take({pair_table(figures)}, figures.size() == sizes.size());
    }
}

void measure_all_features(const Communicator& comm, const BenchOptions& options, Progress& progress,
                          BenchOutput& output) {
    const auto sizes = parse_sizes(!options.grains.empty() ? options.grains.c_str()
                                                           : (options.quick ? "3000" : default_feature_sizes));
    const int steps = effort_for(block_grains, options.quick).settle_steps;
    // Without friction a block sloshes for longer, and a pile that moves has lists to renew.
    const FeatureBlocks blocks{settle_block(Communicator::alone(), block_grains, steps),
                               settle_block(Communicator::alone(), block_grains, (options.quick ? 1 : 10) * steps, 0)};
    std::vector<FeatureFigures> figures;
    for (const auto& grains : sizes) {
        progress.info(fmt::format("bench: features at {} grains", grains));
        const auto found =
            measure_features(comm, blocks, grains, options.quick ? FeatureEffort{2, 1} : FeatureEffort{});
        figures.insert(figures.end(), found.begin(), found.end());
        output.take({feature_table(figures)}, &grains == &sizes.back());
    }
}

void measure_all_smooth(const Communicator& comm, const BenchOptions& options, Progress& progress,
                        BenchOutput& output) {
    const auto sizes =
        parse_sizes(!options.grains.empty() ? options.grains.c_str() : (options.quick ? "3000" : default_smooth_sizes));
    const auto block =
        settle_block(Communicator::alone(), block_grains, effort_for(block_grains, options.quick).settle_steps);
    std::vector<SmoothFigures> figures;
    for (const auto grains : sizes) {
        progress.info(fmt::format("bench: smooth contacts of {} grains", grains));
        figures.push_back(measure_smooth(comm, block, grains, options.quick ? 3 : 11, options.quick ? 0.005 : 0.2));
        output.take({smooth_table(figures, comm.size())}, figures.size() == sizes.size());
    }
}

void check(const Communicator& comm, const BenchOptions& options) {
    if (!options.grains.empty()) {
        parse_sizes(options.grains);
    }
    if (options.pairs != 0 && comm.size() == 1) {
        throw InputError("--pairs: compares one rank with several, found 1; start it under mpirun -n 2");
    }
}

} // namespace

std::vector<std::int64_t> parse_sizes(std::string_view text) {
    std::vector<std::int64_t> sizes;
    for (std::size_t at = 0; at <= text.size();) {
        const auto comma = std::min(text.find(',', at), text.size());
        const auto item = text.substr(at, comma - at);
        std::int64_t n = 0;
        const auto [end, error] = std::from_chars(item.data(), item.data() + item.size(), n);
        if (error != std::errc() || end != item.data() + item.size() || n < block_grains || n > most_grains) {
            throw InputError(fmt::format("--grains: must be whole numbers from {} (one settled block, of which samples "
                                         "are made) to {}, found '{}'; write them with commas between: {}",
                                         block_grains, most_grains, item, default_sizes));
        }
        sizes.push_back(n);
        at = comma + 1;
    }
    return sizes;
}

ExitCode bench(const Communicator& comm, const BenchOptions& options) {
    check(comm, options);
    Progress progress(Progress::for_rank(comm.is_root()));
    BenchOutput output(comm, options, machine_of(comm));
    const double total = seconds_of([&] {
        if (options.pairs != 0) {
            measure_all_pairs(comm, options, progress, output);
        } else if (options.smooth) {
            measure_all_smooth(comm, options, progress, output);
        } else if (options.features) {
            measure_all_features(comm, options, progress, output);
        } else {
            measure_sizes(comm, options, progress, output);
        }
    });
    progress.info(fmt::format("bench: {:.0f} s", comm.max(total)));
    return ExitCode::done;
}

} // namespace nappe
