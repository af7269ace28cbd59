#include "commands/bench.hpp"
#include "commands/check.hpp"
#include "commands/info.hpp"
#include "commands/measure.hpp"
#include "commands/partitions.hpp"
#include "commands/run.hpp"
#include "commands/trade.hpp"
#include "core/error.hpp"
#include "io/summary.hpp"

#include <CLI/CLI.hpp>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <new>

namespace {

using nappe::ExitCode;

/// Says it once, on rank 0: errors are the same on all ranks.
int failed(const nappe::Communicator& world, const char* what, ExitCode code) {
    if (world.is_root()) {
        std::fprintf(stderr, "nappe: %s\n", what);
    }
    return static_cast<int>(code);
}

struct Arguments {
    nappe::RunOptions run;
    std::string checkpoint_every, wall_time;
    std::filesystem::path info;
    nappe::CostModel cost;
    nappe::BenchOptions bench;
    int ranks = 2;
    nappe::PartitionsOptions partitions;
    nappe::MeasureOptions measure;
    nappe::TradeOptions trade;
};

void define_measure(CLI::App& app, nappe::MeasureOptions& options) {
    auto* measure =
        app.add_subcommand("measure", "measure the stored frames of a run (docs/measures.md); start it under "
                                      "mpirun for several ranks");
    measure->add_option("run", options.run, "folder that a run wrote")->required();
    measure->add_option("--out", options.out, "folder for the measures [measures in that of the run]")
        ->type_name("DIR");
    measure
        ->add_option("--set", options.overrides,
                     "override a key of output.measures or output.zone: --set output.measures.range=4")
        ->type_name("KEY=VALUE")
        ->allow_extra_args(false)
        ->take_all();
}

void define_bench(CLI::App& app, nappe::BenchOptions& options) {
    auto* bench =
        app.add_subcommand("bench", "measure this machine, the kernels, the steps and the memory; start it under "
                                    "mpirun for several ranks");
    bench->footer(
        "The default takes some minutes and about 3 GB, on a quiet machine; compare figures of one run only.");
    bench
        ->add_option("--grains", options.grains,
                     "sizes to measure [3000,10000,43000,172000,688000,2700000; with --pairs 10000,43000; with "
                     "--features 43000; with --smooth 3000,10000,43000,100000,1000000]")
        ->type_name("N,N,...");
    auto* pairs =
        bench->add_option("--pairs", options.pairs, "instead: one rank against all, in so many alternating turns")
            ->type_name("N")
            ->check(CLI::Range(1, 100000).description(""));
    auto* features =
        bench
            ->add_flag("--features", options.features,
                       "instead: what friction, cohesion and all else that a scene may ask for add in bytes and time")
            ->excludes(pairs);
    bench
        ->add_flag("--smooth", options.smooth,
                   "instead: what a step of smooth contacts costs; on several ranks also what they save")
        ->excludes(pairs)
        ->excludes(features);
    bench->add_option("--json", options.json, "write the figures to this file too")->type_name("FILE");
    bench->add_flag("--quick", options.quick, "one small size and few rounds: whether it works, not how fast it is");
}

void define_trade(CLI::App& trade, nappe::TradeOptions& options) {
    trade.add_option("--matrix", options.matrix, "file of settings (docs/accuracy.md) [jobs/trade-default.toml]")
        ->type_name("FILE");
    trade.add_option("--out", options.out, "folder for runs and tables [out/NAME OF THE SCENE-trade]")
        ->type_name("DIR");
    trade.add_option("--samples", options.samples, "folder that keeps settled samples [samples beside DIR]")
        ->type_name("DIR");
    trade.add_option("--seeds", options.seeds, "run the sample's seeds 1 to N, whatever the matrix lists")
        ->type_name("N")
        ->check(CLI::Range(1, 10000).description(""));
}

/// What `run` and `restart` share.
void define_course(CLI::App& command, Arguments& arguments) {
    auto& run = arguments.run;
    command.add_option("--samples", run.samples, "folder that keeps settled samples [samples beside DIR]")
        ->type_name("DIR");
    command.add_option("--steps", run.steps, "stop after this many steps of loading")
        ->type_name("N")
        ->check(CLI::Range(std::int64_t{0}, std::int64_t{1} << 40).description(""));
    command.add_option(
        "--kernel", run.kernel,
        "instruction set of the sweep: scalar, portable, avx2 or avx512 [the fastest here]; results are the same");
    command
        .add_option("--checkpoint-every", arguments.checkpoint_every,
                    "write a checkpoint every so many steps, minutes or whichever comes first: 500, 10min, "
                    "\"500,10min\", never [10min]")
        ->type_name("N,T");
    command
        .add_option("--wall-time", arguments.wall_time,
                    "write a checkpoint and stop (exit code 3) before so much time has passed")
        ->type_name("HH:MM:SS");
}

/// Throws InputError.
void read_course(Arguments& arguments) {
    auto& settings = arguments.run.checkpoints;
    if (!arguments.checkpoint_every.empty()) {
        settings.policy = nappe::parse_checkpoint_policy(arguments.checkpoint_every);
    }
    if (!arguments.wall_time.empty()) {
        settings.wall_time = nappe::parse_wall_time(arguments.wall_time);
    }
}

/// Where the results of a scene go, and its samples, if the command line does not say.
void default_folders(const std::string& scene, const char* suffix, std::filesystem::path& out,
                     std::filesystem::path& samples) {
    if (out.empty()) {
        out = std::filesystem::path("out") / (std::filesystem::path(scene).stem().string() + suffix);
    }
    if (samples.empty()) {
        samples = std::filesystem::absolute(out).lexically_normal().parent_path() / "samples";
    }
}

void define(CLI::App& app, Arguments& arguments) {
    app.description("nappe: contact dynamics of large collections of rigid grains, on any number of MPI ranks");
    app.set_version_flag("--version", std::string(nappe::program_version()));
    app.require_subcommand(1);
    app.footer(
        "Exit codes: 0 done, 2 bad input, 3 stopped early and restartable, 4 numerical failure, 1 anything else.");
    const auto add_overrides = [&](CLI::App* command) {
        command->add_option("--set", arguments.run.overrides, "override a key: --set solver.h=0.01 (may be repeated)")
            ->type_name("KEY=VALUE")
            ->allow_extra_args(false)
            ->take_all();
    };
    const auto scene_of = [&](CLI::App* command) {
        command->add_option("scene", arguments.run.scene, "scene file (TOML; docs/scene.md)")->required();
        add_overrides(command);
    };
    auto* run = app.add_subcommand("run", "run a scene; start it under mpirun for several ranks");
    scene_of(run);
    run->add_option("--out", arguments.run.out, "folder for the results [out/NAME OF THE SCENE]")->type_name("DIR");
    define_course(*run, arguments);
    run->add_flag("--overwrite", arguments.run.overwrite, "throw away the run that lies in DIR");
    auto* restart =
        app.add_subcommand("restart", "go on with a run that was stopped, from its newest checkpoint; on any "
                                      "number of ranks, to the same results");
    restart->add_option("run", arguments.run.out, "folder of the run, its --out")->required()->type_name("DIR");
    add_overrides(restart);
    define_course(*restart, arguments);
    auto* check = app.add_subcommand("check", "validate a scene; estimate grains, memory and work");
    scene_of(check);
    check->add_option("--ranks", arguments.ranks, "estimate for this many ranks [2]");
    check->add_option("--ns", arguments.cost.ns_per_relaxation, "nanoseconds per relaxation and rank to assume");
    auto* cut = app.add_subcommand("partitions", "cut a scene for many ranks; count what each would compute and send");
    scene_of(cut);
    auto& partitions = arguments.partitions;
    cut->add_option("--parts", partitions.parts, "numbers of ranks to cut for [1,2,4 to 4096]")
        ->type_name("P,P,...")
        ->delimiter(',')
        ->allow_extra_args(false);
    cut->add_option("--scale", partitions.scale, "multiply the lengths of profile and walls [1]");
    cut->add_option("--tile-scale", partitions.tile_scale,
                    "and once more by this, counted by tiles: for samples too large to make");
    cut->add_option("--samples", partitions.samples, "take the settled sample from here [the deposit]")
        ->type_name("DIR");
    cut->add_option("--json", partitions.json, "write the counts of every part and every message")->type_name("FILE");
    auto* trade = app.add_subcommand("trade", "run a scene with a matrix of solver settings; what each costs, and how "
                                              "far it is from a tight reference");
    scene_of(trade);
    define_trade(*trade, arguments.trade);
    auto* info =
        app.add_subcommand("info", "what a frame, a sample, a checkpoint or the folder of a run holds, and whether "
                                   "it is sound");
    info->add_option("file", arguments.info, "file or folder")->required();
    define_measure(app, arguments.measure);
    define_bench(app, arguments.bench);
}

int dispatch(const nappe::Communicator& world, const CLI::App& app, Arguments& arguments) {
    if (app.got_subcommand("bench")) {
        return static_cast<int>(nappe::bench(world, arguments.bench));
    }
    if (app.got_subcommand("check")) {
        std::string error;
        int code = static_cast<int>(ExitCode::done);
        if (world.is_root()) {
            try {
                code = nappe::check(arguments.run.scene, arguments.run.overrides, arguments.cost, arguments.ranks);
            } catch (const nappe::InputError& e) {
                error = e.what();
            }
        }
        world.throw_together<nappe::InputError>(error);
        return code;
    }
    if (app.got_subcommand("info")) {
        return static_cast<int>(nappe::info(world, arguments.info));
    }
    if (app.got_subcommand("measure")) {
        return static_cast<int>(nappe::measure(world, arguments.measure));
    }
    if (app.got_subcommand("partitions")) {
        auto& options = arguments.partitions;
        options.scene = arguments.run.scene;
        options.overrides = arguments.run.overrides;
        nappe::partitions(world, options);
        return static_cast<int>(ExitCode::done);
    }
    if (app.got_subcommand("trade")) {
        auto& options = arguments.trade;
        options.scene = arguments.run.scene;
        options.overrides = arguments.run.overrides;
        default_folders(options.scene, "-trade", options.out, options.samples);
        return static_cast<int>(nappe::trade(world, options));
    }
    auto& options = arguments.run;
    read_course(arguments);
    default_folders(options.scene, "", options.out, options.samples);
    if (app.got_subcommand("restart")) {
        return static_cast<int>(nappe::restart(world, options));
    }
    return static_cast<int>(nappe::run(world, options));
}

int guarded(const nappe::Communicator& world, const CLI::App& app, Arguments& arguments) {
    try {
        return dispatch(world, app, arguments);
    } catch (const nappe::InputError& e) {
        return failed(world, e.what(), ExitCode::bad_input);
    } catch (const nappe::NumericalFailure& e) {
        return failed(world, e.what(), ExitCode::numerical_failure);
    } catch (const nappe::SystemError& e) {
        return failed(world, e.what(), ExitCode::other);
    } catch (const std::bad_alloc&) {
        std::fprintf(
            stderr,
            "nappe: rank %d: there must be memory for the rank's part of the scene, found too little; nappe check "
            "says what a scene needs: take more ranks on more nodes, or fewer grains\n",
            world.rank());
        world.abort(static_cast<int>(ExitCode::other));
    } catch (const std::exception& e) {
        // Not one that ranks agreed on: the others may be waiting, so the whole job ends here.
        std::fprintf(stderr, "nappe: rank %d: %s\n", world.rank(), e.what());
        world.abort(static_cast<int>(ExitCode::other));
    }
}

} // namespace

int main(int argc, char** argv) {
    std::signal(SIGXFSZ, SIG_IGN); // a limit on file sizes is an error of the write, which is told in words
    nappe::MpiSession mpi(argc, argv);
    const nappe::Communicator world;
    CLI::App app;
    Arguments arguments;
    define(app, arguments);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& e) {
        const bool asked = e.get_exit_code() == 0; // --help, --version
        if (world.is_root()) {
            app.exit(e);
        }
        return static_cast<int>(asked ? ExitCode::done : ExitCode::bad_input);
    }
    return guarded(world, app, arguments);
}
