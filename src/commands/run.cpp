#include "commands/run.hpp"

#include "commands/prepare.hpp"
#include "commands/recorder.hpp"
#include "io/scene_reader.hpp"
#include "io/summary.hpp"
#include "solver/fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>

namespace nappe {

namespace {

volatile std::sig_atomic_t signal_caught = 0;

void remember_signal(int number) {
    signal_caught = number;
}

} // namespace

void catch_signals() {
    struct sigaction action {};
    action.sa_handler = remember_signal;
    action.sa_flags = SA_RESETHAND; // a second signal ends the process at once
    for (const int number : {SIGUSR1, SIGUSR2, SIGTERM, SIGINT}) {
        sigaction(number, &action, nullptr);
    }
    std::signal(SIGPIPE, SIG_IGN);
}

bool stop_asked(const Communicator& comm) {
    return comm.bit_or(signal_caught != 0 ? 1U : 0U) != 0;
}

std::string shared_text(const Communicator& comm, const std::string& path, std::string (*read)(const std::string&)) {
    std::string text, error;
    if (comm.is_root()) {
        try {
            text = read(path);
        } catch (const InputError& e) {
            error = e.what();
        }
    }
    comm.throw_together<InputError>(error);
    comm.broadcast(text);
    return text;
}

namespace {

struct Course {
    std::int64_t steps = 0;
    double time = 0;
    bool stopped = false;
};

/// The loading stages, from step 0 to the last.
Course load_stages(Simulation<2>& simulation, Recorder& recorder, Progress& progress,
                   const std::optional<std::int64_t>& limit) {
    const auto& scene = simulation.scene();
    Course course;
    bool begun = false;
    std::int64_t all = 0;
    for (const auto& stage : scene.stages) {
        all += stage.until ? 0 : n_steps(stage);
    }
    all = limit ? std::min(all, *limit) : all;
    for (int s = 0; s < static_cast<int>(scene.stages.size()) && !course.stopped; ++s) {
        const auto& stage = scene.stages[static_cast<std::size_t>(s)];
        const bool last = s + 1 == static_cast<int>(scene.stages.size());
        if (stage.until && !last) {
            continue;
        }
        simulation.start_stage(s);
        if (!begun) {
            begun = true;
            simulation.mark_cells();
            recorder.begin();
            recorder.write_frame(0, 0.0);
        }
        const std::int64_t n = stage.until ? 0 : std::min(n_steps(stage), all - course.steps);
        progress.begin_stage(stage.name, n);
        for (std::int64_t k = 0; k < n && !course.stopped; ++k) {
            const bool final_step = course.steps + 1 == all;
            const bool row = recorder.row_due(course.steps + 1) || final_step;
            const auto outside = simulation.step(signal_caught != 0 ? flag::outside_first : 0, row);
            ++course.steps;
            course.time = simulation.time();
            course.stopped = outside != 0 && !final_step;
            if (row) {
                recorder.write_row(course.steps, course.time);
            }
            const int every = scene.output.frames_every;
            if (final_step || course.stopped || (every > 0 && course.steps % every == 0)) {
                recorder.write_frame(course.steps, course.time);
            }
            progress.update(k + 1, course.time);
        }
        progress.end_stage();
    }
    return course;
}

/// Seconds of each stage on the slowest rank; sweeping without the exchange inside it.
nlohmann::ordered_json stage_seconds(Simulation<2>& simulation, double& sweeping_all_ranks) {
    auto seconds = simulation.watch().seconds();
    const auto at = [](Timed t) { return static_cast<std::size_t>(t); };
    const auto& comm = simulation.comm();
    ExactSum sweeping;
    sweeping.add(seconds[at(Timed::sweep)]);
    comm.sum(sweeping.limbs());
    sweeping_all_ranks = sweeping.value();
    seconds[at(Timed::sweep)] -= seconds[at(Timed::exchange)];
    nlohmann::ordered_json json;
    for (std::size_t k = 0; k < n_timed; ++k) {
        json[timed_names[k]] = comm.max(seconds[k]);
    }
    return json;
}

} // namespace

ExitCode run(const Communicator& comm, const RunOptions& options) {
    const auto text = shared_text(comm, options.scene, read_scene_text);
    const auto scene = parse_scene(text, options.scene, options.overrides); // every rank finds the same errors
    Progress progress(Progress::for_rank(comm.is_root()));
    return run_scene(comm, scene, options, progress);
}

ExitCode run_scene(const Communicator& comm, const Scene<2>& scene, const RunOptions& options, Progress& progress) {
    const auto start = std::chrono::steady_clock::now();
    const auto& kernels = disk_kernels(options.kernel.empty() ? nullptr : options.kernel.c_str());
    catch_signals();
    Recorder::claim(comm, options.out, options.samples);
    Simulation<2> simulation(comm, scene, kernels);
    const auto features = features_of(scene);
    progress.info(
        fmt::format("{}: {} ranks, disks in the plane, {} friction, {} restitution, {} cohesion, {} kernel ({}), "
                    "{} B per grain, {} B per contact",
                    scene.title, comm.size(), features.friction ? "Coulomb" : "no",
                    features.restitution ? "Newton" : "no", features.cohesion ? "Lennard-Jones" : "no", kernels.name,
                    kernel_variant(features), bytes_per_grain(features), bytes_per_contact(features)));
    if (couples_by_sweep(scene) && comm.size() > 1) {
        progress.warning(fmt::format("solver.coupling = \"sweep\": the result holds for {} ranks; on another number of "
                                     "ranks it differs",
                                     comm.size()));
    }
    Preparation preparation;
    try {
        preparation = prepare(simulation, options.samples, progress, signal_caught);
    } catch (const StoppedEarly&) {
        progress.warning("stopped by a signal while preparing; there are no results");
        return ExitCode::stopped_early;
    }
    simulation.watch().clear();
    const auto loading = std::chrono::steady_clock::now();
    Recorder recorder(simulation, options.out);
    const Course course = load_stages(simulation, recorder, progress, options.steps);
    recorder.finish();

    const auto hash = simulation.state_hash();
    const auto& counters = simulation.counters();
    const auto relaxations = comm.sum(counters.relaxations);
    const auto messages = comm.sum(simulation.domain().halo().traffic().messages_sent);
    const auto bytes = comm.sum(simulation.domain().halo().traffic().bytes_sent);
    double sweeping = 0;
    const auto seconds = stage_seconds(simulation, sweeping);
    const auto now = std::chrono::steady_clock::now();
    const auto elapsed = [&](auto since) { return comm.max(std::chrono::duration<double>(now - since).count()); };
    const double total = elapsed(start), loaded = elapsed(loading);
    const auto& residual = simulation.last_residual();
    nlohmann::ordered_json json;
    json["version"] = program_version();
    json["title"] = scene.title;
    json["scene"] = scene.text;
    json["ranks"] = comm.size();
    json["coupling"] = couples_by_sweep(scene) ? "sweep" : "colour";
    json["rank_independent"] = !couples_by_sweep(scene);
    json["grains"] = simulation.domain().n_grains();
    json["mass"] = simulation.total_mass();
    json["contacts"] = recorder.last_overlaps().contacts;
    json["candidates"] = recorder.last_overlaps().candidates;
    json["steps"] = course.steps;
    json["h"] = simulation.settings().h / simulation.settings().substeps;
    json["time_simulated"] = course.time;
    json["stopped_early"] = course.stopped;
    json["relaxations"] = relaxations;
    json["sweeps"] = counters.sweeps;
    json["reductions"] = counters.reductions;
    json["unconverged_steps"] = counters.unconverged;
    json["seconds_total"] = total;
    json["seconds_loading"] = loaded;
    json["seconds_deposit"] = comm.max(preparation.deposit_seconds);
    json["seconds_settle"] = comm.max(preparation.settle_seconds);
    json["settle_steps"] = preparation.settle_steps;
    json["sample_reused"] = preparation.reused;
    json["seconds"] = seconds;
    json["ns_per_relaxation"] = relaxations > 0 ? 1e9 * sweeping / static_cast<double>(relaxations) : 0.0;
    json["kernel"] = kernels.name;
    json["kernel_variant"] = kernel_variant(features);
    json["rebuilds"] = counters.rebuilds;
    json["redone_lists"] = counters.redone_lists;
    json["redone_groups"] = counters.redone_groups;
    json["redone_packs"] = counters.redone_packs;
    json["rebalanced"] = counters.rebalanced;
    const auto busiest = comm.max(counters.relaxations);
    json["imbalance"] =
        relaxations > 0 ? static_cast<double>(busiest) * comm.size() / static_cast<double>(relaxations) : 1.0;
    json["imbalance_last"] = simulation.domain().last_imbalance();
    json["messages"] = messages;
    json["message_bytes"] = bytes;
    json["correction_work"] = simulation.correction_work();
    json["overlap_mean"] = recorder.last_overlaps().mean;
    json["overlap_max"] = recorder.last_overlaps().largest;
    json["overlap_max_of_rows"] = recorder.largest_overlap();
    json["residual"] = residual ? nlohmann::ordered_json(residual->largest) : nlohmann::ordered_json();
    json["residual_max_of_rows"] = recorder.largest_residual();
    json["bytes_per_grain"] = bytes_per_grain(features);
    json["bytes_per_contact"] = bytes_per_contact(features);
    json["state_hash"] = hex_digits(hash);
    std::string error;
    if (comm.is_root()) {
        try {
            write_summary(options.out / "summary.json", json);
        } catch (const SystemError& e) {
            error = e.what();
        }
    }
    comm.throw_together<SystemError>(error);
    progress.info(fmt::format(
        "{} steps, {} s simulated in {:.1f} s; largest overlap {:.3g} r, residual {:.3g}; state hash {}", course.steps,
        course.time, loaded, recorder.largest_overlap(), recorder.largest_residual(), hex_digits(hash)));
    return course.stopped ? ExitCode::stopped_early : ExitCode::done;
}

} // namespace nappe
