#include "commands/info.hpp"

#include "io/checkpoint_store.hpp"
#include "io/folder_lock.hpp"
#include "io/hdf5_reader.hpp"
#include "io/stored_rows.hpp"
#include "io/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <fstream>

namespace nappe {

namespace {

void say(const std::string& key, const std::string& value) {
    fmt::print("{:<12} {}\n", key, value);
}

std::string shown(const nlohmann::ordered_json& json) {
    return json.is_string() ? json.get<std::string>() : json.dump();
}

/// A sample or a checkpoint. @returns why it is not sound, or nothing
std::string describe_stored(const std::filesystem::path& path) {
    const auto alone = Communicator::alone();
    const auto file = examine_stored(alone, path);
    const auto& manifest = file.manifest;
    if (manifest.file_bytes > 0) {
        say("kind", manifest.notes.value("kind", std::string("sample")));
        say("grains", fmt::format("{}", manifest.n_grains));
        say("contacts", fmt::format("{}", manifest.n_contacts));
        say("bytes", fmt::format("{}", manifest.file_bytes));
        say("physics",
            fmt::format("{}{}", manifest.physics_revision,
                        manifest.physics_revision == physics_revision ? "" : ", another than this program's"));
        for (const auto& [key, value] : manifest.notes.items()) {
            if (key != "kind") {
                say(key, shown(value));
            }
        }
    }
    say("sound", file.reason.empty() ? "yes: length and checksum are the manifest's" : "no: " + file.reason);
    return file.reason;
}

/// A frame, or fields of one. Throws Hdf5Failure.
void describe_frame(const std::filesystem::path& path) {
    const Hdf5Reader file(path);
    const bool is_frame = file.has("/VTKHDF") && file.has("/contacts");
    say("kind", is_frame ? "frame" : "fields");
    say("title", file.text("/", "title"));
    say("version", file.text("/", "version"));
    say("step", fmt::format("{}", file.integer("/", "step")));
    say("time", fmt::format("{} s", file.number("/", "time")));
    if (is_frame) {
        say("grains", fmt::format("{}", file.rows("/VTKHDF/PointData/id")));
        say("contacts", fmt::format("{}", file.rows("/contacts/lo")));
    }
    say("sound", "it opens; frames have no checksum");
}

std::string state_of_run(const std::filesystem::path& folder, bool has_checkpoint) {
    if (const auto holder = FolderLock::holder_of(folder); !holder.empty()) {
        return "running: " + holder;
    }
    std::ifstream file(folder / "summary.json");
    const auto summary = nlohmann::ordered_json::parse(file, nullptr, false);
    if (!summary.is_object()) {
        return has_checkpoint ? "failed or killed: nappe restart goes on from the newest sound checkpoint"
                              : "failed or killed before its first checkpoint";
    }
    say("title", value_of(summary, "title", std::string()));
    say("steps", fmt::format("{}", value_of(summary, "steps", std::int64_t{0})));
    say("state hash", value_of(summary, "state_hash", std::string()));
    const std::string state = value_of(summary, "stopped_early", false) ? "stopped early" : "come to its end";
    return state + (has_checkpoint ? "; nappe restart goes on with what is left of its scene" : "");
}

/// The folder of a run. @returns whether it is one
bool describe_run(const std::filesystem::path& folder) {
    const auto kept = folder / "checkpoints";
    const auto serials = checkpoint_serials(kept);
    std::error_code none;
    if (serials.empty() && !std::filesystem::exists(folder / "scene.toml", none) &&
        !std::filesystem::exists(folder / "summary.json", none)) {
        return false;
    }
    say("kind", "run");
    const auto state = state_of_run(folder, !serials.empty());
    say("state", state);
    std::int64_t frames = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "frames", none)) {
        frames += entry.path().extension() == ".hdf" ? 1 : 0;
    }
    say("frames", fmt::format("{}", frames));
    const auto alone = Communicator::alone();
    for (const auto serial : serials) {
        const auto path = checkpoint_path(kept, serial);
        const auto file = examine_stored(alone, path);
        const auto& notes = file.manifest.notes;
        say("checkpoint", file.reason.empty()
                              ? fmt::format("{}: stage '{}', step {}, t = {} s", path.string(),
                                            value_of(notes, "stage", std::string("?")),
                                            value_of(notes, "step", std::int64_t{-1}), value_of(notes, "time", 0.0))
                              : fmt::format("{}: not sound: {}", path.string(), file.reason));
    }
    return true;
}

/// Whether a manifest can be read from it.
bool checkpoint_or_sample(const std::filesystem::path& manifest) {
    try {
        parse_manifest(read_text(manifest));
        return true;
    } catch (const std::exception&) {
        return false;
    }
}

/// On the root. What is wrong, or nothing.
std::string describe(const std::filesystem::path& path) {
    constexpr const char* rule =
        "must be a file that nappe wrote (a frame, a sample, a checkpoint), or the folder of a run";
    std::error_code none;
    if (std::filesystem::is_directory(path, none)) {
        return describe_run(path) ? std::string() : fmt::format("{}: {}, found another folder", path.string(), rule);
    }
    if (std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none)) {
        return fmt::format("{}: {}, found something else than a file", path.string(), rule);
    }
    if (!std::filesystem::exists(path, none)) {
        return fmt::format("{}: {}, found nothing of that name; check the path", path.string(), rule);
    }
    auto file = path;
    file.replace_extension(".hdf");
    // Any .json may be beside a name: a manifest is what has its file, or calls itself one.
    if (std::filesystem::exists(manifest_path(file), none) &&
        (std::filesystem::exists(file, none) || checkpoint_or_sample(manifest_path(file)))) {
        const auto reason = describe_stored(file);
        return reason.empty()
                   ? std::string()
                   : fmt::format("{}: must be what its manifest says, found otherwise: {}; nappe does not use "
                                 "it, it can be deleted",
                                 file.string(), reason);
    }
    try {
        describe_frame(path);
    } catch (const std::exception& e) {
        return fmt::format("{}: {}, found: {}", path.string(), rule, e.what());
    }
    return {};
}

} // namespace

ExitCode info(const Communicator& comm, const std::filesystem::path& path) {
    std::string error;
    if (comm.is_root()) {
        error = describe(path);
        std::fflush(stdout);
    }
    comm.throw_together<InputError>(error);
    return ExitCode::done;
}

} // namespace nappe
