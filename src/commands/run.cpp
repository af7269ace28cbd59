#include "commands/run.hpp"

#include "commands/loading.hpp"
#include "commands/prepare.hpp"
#include "commands/recorder.hpp"
#include "commands/restart_rules.hpp"
#include "commands/run_totals.hpp"
#include "commands/signals.hpp"
#include "commands/watch_report.hpp"
#include "core/smooth_step.hpp"
#include "io/folder_lock.hpp"
#include "io/scene_reader.hpp"
#include "io/summary.hpp"
#include "solver/fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>

namespace nappe {

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

/// On the root. What a new run there would destroy, and the remedy; empty: nothing.
std::string would_be_lost(const RunOptions& options) {
    namespace fs = std::filesystem;
    std::error_code none;
    const auto& out = options.out;
    const auto kept = out / "scene.toml";
    const bool has_scene = fs::exists(kept, none);
    if (has_scene && fs::equivalent(kept, options.scene, none)) {
        return fmt::format("{}: must not be the folder of the scene file if that is called scene.toml, since results "
                           "keep the scene as run under this name; choose another --out",
                           out.string());
    }
    const bool has_summary = fs::exists(out / "summary.json", none);
    if (has_scene && !has_summary && !fs::exists(out / "frames", none)) {
        return fmt::format("{}: must not hold a scene.toml that no run left, found one; results keep the scene as run "
                           "under this name: choose another --out",
                           out.string());
    }
    if (options.overwrite) {
        return {};
    }
    if (!checkpoint_serials(out / "checkpoints").empty()) {
        return fmt::format(
            "{0}: must not hold a run that can go on, found its checkpoints; go on with nappe restart {0}, "
            "choose another --out, or begin anew with --overwrite",
            out.string());
    }
    const bool has_frames = std::any_of(fs::directory_iterator(out / "frames", none), fs::directory_iterator(),
                                        [](const auto& entry) { return entry.path().extension() == ".hdf"; });
    if (has_summary || has_frames) {
        return fmt::format(
            "{}: must not hold the results of another run, found {}; choose another --out, or throw them away with "
            "--overwrite",
            out.string(), has_summary ? "its summary.json" : "its frames, and no checkpoint to go on from");
    }
    return {};
}

/// **Collective.** Machines of one job may differ: if the kernel is not for one of them, all ranks say so.
const DiskKernels& kernels_of(const Communicator& comm, const std::string& name) {
    const DiskKernels* kernels = nullptr;
    std::string error;
    try {
        kernels = &disk_kernels(name.empty() ? nullptr : name.c_str());
    } catch (const InputError& e) {
        error = e.what();
    }
    comm.throw_together<InputError>(error);
    return *kernels;
}

std::string how_to_go_on(bool kept, bool any, const std::filesystem::path& out) {
    return kept  ? fmt::format("; go on with nappe restart {}", out.string())
           : any ? fmt::format(", and this state is in no checkpoint; nappe restart {} goes on from the one before",
                               out.string())
                 : std::string(", and there is no checkpoint to go on from");
}

void say_what_is_run(const Simulation<2>& simulation, const DiskKernels& kernels, Progress& progress) {
    const auto& scene = simulation.scene();
    const auto features = features_of(scene);
    const int ranks = simulation.comm().size();
    progress.info(
        fmt::format("{}: {} ranks, disks in the plane, {} friction, {} restitution, {} cohesion, {} kernel ({}), "
                    "{} B per grain, {} B per contact",
                    scene.title, ranks, features.friction ? "Coulomb" : "no", features.restitution ? "Newton" : "no",
                    features.cohesion ? "Lennard-Jones" : "no", kernels.name, kernel_variant(features),
                    bytes_per_grain(features), bytes_per_contact(features)));
    for (const auto& line : smooth_warnings(scene)) {
        progress.warning(line);
    }
    if (couples_by_sweep(scene) && ranks > 1) {
        progress.warning(fmt::format("solver.coupling = \"sweep\": the result holds for {} ranks; on another number of "
                                     "ranks it differs",
                                     ranks));
    }
}

} // namespace

void warn_without_lock(const FolderLock& lock, const std::filesystem::path& folder, Progress& progress) {
    if (!lock.held()) { // who is not the root says nothing
        progress.warning(fmt::format("{}: this file system has no locks, so a second run in the folder would not be "
                                     "refused; see to it that there is none",
                                     folder.string()));
    }
}

ExitCode run(const Communicator& comm, const RunOptions& options) {
    catch_signals();
    const auto text = shared_text(comm, options.scene, read_scene_text);
    const auto scene = parse_scene(text, options.scene, options.overrides); // every rank finds the same errors
    kernels_of(comm, options.kernel);                                       // before anything is written
    Progress progress(Progress::for_rank(comm.is_root()));
    const FolderLock lock(comm, options.out);
    warn_without_lock(lock, options.out, progress);
    comm.throw_together<InputError>(comm.is_root() ? would_be_lost(options) : std::string());
    return run_scene(comm, scene, options, progress);
}

ExitCode run_scene(const Communicator& comm, const Scene<2>& scene, const RunOptions& options, Progress& progress,
                   const Checkpoint<2>* from) {
    const auto start = std::chrono::steady_clock::now();
    const auto& kernels = kernels_of(comm, options.kernel);
    if (from == nullptr) {
        Recorder::claim(comm, options.out, options.samples);
    } else {
        Recorder::reclaim(comm, options.out, from->course, options.samples);
    }
    Simulation<2> simulation(comm, scene, kernels);
    say_what_is_run(simulation, kernels, progress);
    Checkpointer checkpointer(simulation, progress, options.out / "checkpoints", restart_key(scene),
                              options.checkpoints, from != nullptr ? from->serial + 1 : 1);
    RunTotals before;
    const nlohmann::ordered_json* course = from != nullptr ? &from->course : nullptr;
    bool loading_begun = false;
    if (course != nullptr) {
        simulation.resume(from->snapshot);
        checkpointer.keep(from->serial);
        before = totals_from(course->at("totals"));
        ++before.restarts;
        loading_begun = course->at("loading").get<bool>();
    }
    auto loading = start;
    Preparation preparation;
    const auto seconds_since = [&](auto when) {
        return comm.max(std::chrono::duration<double>(std::chrono::steady_clock::now() - when).count());
    };
    const auto totals_now = [&] {
        auto totals = loading_begun ? totals_of(simulation) : RunTotals{};
        totals.all = seconds_since(start);
        totals.loading = loading_begun ? seconds_since(loading) : 0.0;
        totals.checkpoints = checkpointer.written();
        totals.writing = comm.max(checkpointer.seconds());
        totals += before;
        return totals;
    };
    const auto remember = [&](nlohmann::ordered_json& json) {
        json["totals"] = to_json(totals_now());
        if (loading_begun) {
            json["preparation"] = to_json(preparation);
        }
    };
    if (loading_begun) {
        preparation = preparation_from(course->at("preparation"));
    } else {
        try {
            preparation = prepare(simulation, options.samples, progress, checkpointer, course, remember);
        } catch (const StoppedEarly& stopped) {
            progress.warning("stopped while preparing" + how_to_go_on(stopped.kept, checkpointer.any(), options.out));
            return checkpointer.any() ? ExitCode::stopped_early : ExitCode::other;
        }
    }
    const bool resumed = loading_begun;
    loading_begun = true;
    simulation.watch().clear();
    loading = std::chrono::steady_clock::now();
    Recorder recorder(simulation, options.out, resumed ? &course->at("recorder") : nullptr);
    Loading loader(simulation, recorder, checkpointer, progress, options.steps, remember);
    const Course done = loader.go(resumed ? std::optional(course->at("steps").get<std::int64_t>()) : std::nullopt);
    recorder.finish();

    const auto features = features_of(scene);
    const auto hash = simulation.state_hash();
    const auto& counters = simulation.counters();
    const auto totals = totals_now();
    const auto relaxations = totals.relaxations;
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
    json["steps"] = done.steps;
    json["h"] = simulation.settings().h / simulation.settings().substeps;
    json["time_simulated"] = done.time;
    json["stopped_early"] = done.stopped;
    json["restartable"] = checkpointer.any();
    json["restarts"] = totals.restarts;
    json["relaxations"] = relaxations;
    json["sweeps"] = counters.sweeps;
    json["reductions"] = counters.reductions;
    json["unconverged_steps"] = counters.unconverged;
    json["seconds_total"] = totals.all;
    json["seconds_loading"] = totals.loading;
    json["seconds_deposit"] = comm.max(preparation.deposit_seconds);
    json["seconds_settle"] = comm.max(preparation.settle_seconds);
    json["settle_steps"] = preparation.settle_steps;
    json["sample_reused"] = preparation.reused;
    for (std::size_t k = 0; k < n_timed; ++k) {
        json["seconds"][timed_names[k]] = totals.by_stage[k];
    }
    json["ns_per_relaxation"] = relaxations > 0 ? 1e9 * totals.sweeping / static_cast<double>(relaxations) : 0.0;
    json["kernel"] = kernels.name;
    json["kernel_variant"] = kernel_variant(features);
    json["rebuilds"] = counters.rebuilds;
    json["redone_lists"] = counters.redone_lists;
    json["redone_groups"] = counters.redone_groups;
    json["redone_packs"] = counters.redone_packs;
    json["rebalanced"] = counters.rebalanced;
    const auto busiest = comm.max(counters.relaxations), mine = comm.sum(counters.relaxations); // of this process
    json["imbalance"] = mine > 0 ? static_cast<double>(busiest) * comm.size() / static_cast<double>(mine) : 1.0;
    json["imbalance_last"] = simulation.domain().last_imbalance();
    json["messages"] = totals.messages;
    json["message_bytes"] = totals.message_bytes;
    json["checkpoints"] = {{"written", totals.checkpoints},
                           {"failed", checkpointer.failed()},
                           {"seconds", totals.writing},
                           {"bytes", checkpointer.bytes()}};
    json["correction_work"] = simulation.correction_work();
    json["overlap_mean"] = recorder.last_overlaps().mean;
    json["overlap_max"] = recorder.last_overlaps().largest;
    json["overlap_max_of_rows"] = recorder.largest_overlap();
    json["residual"] = residual ? nlohmann::ordered_json(residual->largest) : nlohmann::ordered_json();
    json["residual_max_of_rows"] = recorder.largest_residual();
    json["bytes_per_grain"] = bytes_per_grain(features);
    json["bytes_per_contact"] = bytes_per_contact(features);
    json["watch"] = watch_summary(simulation);
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
        "{} steps, {} s simulated in {:.1f} s; largest overlap {:.3g} r, residual {:.3g}; state hash {}", done.steps,
        done.time, totals.loading, recorder.largest_overlap(), recorder.largest_residual(), hex_digits(hash)));
    show_watch_total(simulation, progress);
    if (done.stopped) {
        progress.warning("stopped" + how_to_go_on(done.kept, checkpointer.any(), options.out));
    }
    return !done.stopped ? ExitCode::done : checkpointer.any() ? ExitCode::stopped_early : ExitCode::other;
}

} // namespace nappe
