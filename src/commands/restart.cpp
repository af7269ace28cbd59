#include "commands/run.hpp"

#include "commands/loading.hpp"
#include "commands/prepare.hpp"
#include "commands/restart_rules.hpp"
#include "commands/run_totals.hpp"
#include "commands/signals.hpp"
#include "io/folder_lock.hpp"
#include "io/scene_reader.hpp"
#include "io/summary.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <fstream>

namespace nappe {

namespace {

/// On the root. The key of the scene that the folder says was run; none if it says nothing that can be read.
std::optional<std::uint64_t> key_of_folder(const std::filesystem::path& folder) {
    const auto path = (folder / "scene.toml").string();
    try {
        return restart_key(parse_scene(read_scene_text(path), path));
    } catch (const InputError&) {
        return std::nullopt;
    }
}

/// On the root. Steps of loading that the run in the folder has come to its end with; none if it has not.
std::optional<std::int64_t> steps_at_end(const std::filesystem::path& folder) {
    std::ifstream file(folder / "summary.json");
    const auto summary = nlohmann::ordered_json::parse(file, nullptr, false);
    if (value_of(summary, "stopped_early", true)) {
        return std::nullopt;
    }
    const auto steps = value_of(summary, "steps", std::int64_t{-1});
    return steps < 0 ? std::nullopt : std::optional(steps);
}

Checkpoint<2> newest(const Communicator& comm, const std::filesystem::path& folder, Progress& progress) {
    auto found = load_newest_checkpoint<2>(comm, folder / "checkpoints");
    if (!found.blocked.empty()) {
        throw InputError(found.blocked);
    }
    if (!found.checkpoint) {
        throw InputError(
            fmt::format("{}: must hold a sound checkpoint to go on from, found {}; begin with nappe run",
                        (folder / "checkpoints").string(),
                        found.reasons.empty() ? "none" : fmt::format("{}", fmt::join(found.reasons, "; "))));
    }
    for (const auto& reason : found.reasons) {
        progress.warning(fmt::format("not used: {}", reason));
    }
    std::string error;
    if (comm.is_root()) {
        const auto key = key_of_folder(folder);
        if (key && *key != found.checkpoint->key) {
            error =
                fmt::format("{}: must be the scene that the run in this folder began with, found another than {} has; "
                            "if you edited it, undo that (what may change goes by --set), or take it away; if the "
                            "checkpoints came from elsewhere, take them away",
                            (folder / "scene.toml").string(),
                            checkpoint_path(folder / "checkpoints", found.checkpoint->serial).string());
        }
    }
    comm.throw_together<InputError>(error);
    try { // the same on all ranks
        totals_from(found.checkpoint->course.at("totals"));
        if (found.checkpoint->course.at("loading").get<bool>()) {
            found.checkpoint->course.at("recorder").at("series").size();
            preparation_from(found.checkpoint->course.at("preparation"));
        }
        found.checkpoint->notes.at("stage").get<std::string>();
    } catch (const nlohmann::json::exception& e) {
        throw InputError(
            fmt::format("{}: must hold what a run remembers of its course, found otherwise: {}; take it out "
                        "of the folder",
                        checkpoint_path(folder / "checkpoints", found.checkpoint->serial).string(), e.what()));
    }
    return std::move(*found.checkpoint);
}

/// A run that came to its end before its first checkpoint has nothing to go on from, nor to.
void refuse_ended(const Communicator& comm, const std::filesystem::path& folder) {
    std::string error;
    if (comm.is_root() && checkpoint_serials(folder / "checkpoints").empty()) {
        if (const auto steps = steps_at_end(folder)) {
            error = fmt::format(
                "{}: must be the folder of a run that can go on, found one that has come to its end with step "
                "{} and left no checkpoint; for a longer one run the scene anew, in another folder",
                folder.string(), *steps);
        }
    }
    comm.throw_together<InputError>(error);
}

} // namespace

ExitCode restart(const Communicator& comm, RunOptions options) {
    catch_signals();
    std::string error;
    std::error_code none;
    if (comm.is_root() && !std::filesystem::is_directory(options.out, none)) {
        error =
            fmt::format("{}: must be the folder of a run, its --out, found none; check the path", options.out.string());
    }
    comm.throw_together<InputError>(error);
    Progress progress(Progress::for_rank(comm.is_root()));
    const FolderLock lock(comm, options.out);
    warn_without_lock(lock, options.out, progress);
    refuse_ended(comm, options.out);
    auto checkpoint = newest(comm, options.out, progress);
    const auto path = checkpoint_path(options.out / "checkpoints", checkpoint.serial);
    const auto before = parse_scene(checkpoint.scene, path.string());
    const auto scene = parse_scene(checkpoint.scene, path.string(), options.overrides);
    check_restart(before, scene, checkpoint.snapshot.clock);
    const bool preparing = !checkpoint.course.at("loading").get<bool>();
    if (preparing && sample_origin(before, comm.size()).made_from != sample_origin(scene, comm.size()).made_from) {
        throw InputError(
            "--set: what a sample is prepared by must be as the run began while it is being prepared, found it "
            "changed: the sample would be of neither kind; leave it away until then, or run the scene anew");
    }
    if (preparing && sample_origin(scene, static_cast<int>(checkpoint.ranks)).made_from !=
                         sample_origin(scene, comm.size()).made_from) {
        throw InputError(fmt::format("{}: must go on on {} ranks while its sample is prepared with solver.coupling = "
                                     "\"sweep\", found {}: the sample would be of neither number; go on on {}, or run "
                                     "the scene anew",
                                     path.string(), checkpoint.ranks, comm.size(), checkpoint.ranks));
    }
    if (const auto at = checkpoint.notes.at("step").get<std::int64_t>();
        !preparing && options.steps.value_or(at) < at) {
        throw InputError(
            fmt::format("--steps: must be at least {}, the step of {}, found {}; leave it away, or give more", at,
                        path.string(), *options.steps));
    }

    options.checkpoints.at_once = scene.text != before.text; // a run that dies soon keeps what --set says
    const auto whole = loading_steps(scene);
    const auto wanted = options.steps ? std::min(*options.steps, whole) : whole;
    const auto ended = comm.max(comm.is_root() ? steps_at_end(options.out).value_or(-1) : -1);
    if (scene.text == before.text && ended >= wanted) {
        progress.info(fmt::format("the run has come to its end with step {}: nothing to do", ended));
        return ExitCode::done;
    }
    if (couples_by_sweep(scene) && checkpoint.ranks != comm.size()) {
        checkpoint.snapshot.owners.clear();
        progress.warning(
            fmt::format("solver.coupling = \"sweep\": on {} ranks instead of {} the results go on otherwise",
                        comm.size(), checkpoint.ranks));
    }
    const auto& notes = checkpoint.notes;
    progress.info(fmt::format("going on from {}: stage '{}', step {}, t = {} s, written by {} ranks", path.string(),
                              notes.at("stage").get<std::string>(), notes.at("step").get<std::int64_t>(),
                              notes.at("time").get<double>(), checkpoint.ranks));
    return run_scene(comm, scene, options, progress, &checkpoint);
}

} // namespace nappe
