// What a recorder needs to go on after a restart, and the order it finds or makes in the folder of a run.

#include "commands/recorder.hpp"

#include "core/error.hpp"
#include "io/checkpoint_store.hpp"
#include "io/exact_json.hpp"
#include "io/folder_lock.hpp"
#include "io/frame_reader.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <set>
#include <unistd.h>

namespace nappe {

namespace {

/// On the root. Folders that can be written, without what died processes left in them; what is wrong, or nothing.
/// @param samples none: the sample is there already, and no other is to be made
std::string make_folders(const std::filesystem::path& folder, const std::filesystem::path& samples) {
    std::error_code code;
    for (const auto& part : {folder / "frames", folder / "series", samples}) {
        if (part.empty()) {
            continue;
        }
        std::filesystem::create_directories(part, code);
        if (code || ::access(part.c_str(), W_OK) != 0) {
            return fmt::format("{}: must be a folder that can be written, found: {}; choose another --out or --samples",
                               part.string(), code ? code.message() : std::strerror(errno));
        }
    }
    for (const auto* part : {"", "frames", "series", "measures", "measures/fields", "checkpoints"}) {
        remove_remains(folder / part, false);
    }
    remove_orphans(folder / "checkpoints");
    if (!samples.empty()) {
        remove_remains(samples, true);
    }
    return {};
}

/// On the root. Results of the run before, which would be taken for the next one's.
void remove_results(const std::filesystem::path& folder) {
    std::error_code ignored;
    std::vector<std::filesystem::path> old;
    const auto collect = [&](const char* part, std::string_view before, const char* kind) {
        for (const auto& entry : std::filesystem::directory_iterator(folder / part, ignored)) {
            if (entry.path().filename().string().starts_with(before) && entry.path().extension() == kind) {
                old.push_back(entry.path());
            }
        }
    };
    collect("frames", "frame-", ".hdf");
    collect("series", "", ".csv");
    for (const auto& path : old) {
        std::filesystem::remove(path, ignored);
    }
}

/// On the root. Whether series are as long as the checkpoint says: before any is cut. What is wrong, or nothing.
std::string lost_rows(const std::filesystem::path& folder, const nlohmann::ordered_json& bytes_of) {
    for (const auto& [name, bytes] : bytes_of.items()) {
        const auto path = folder / "series" / (name + ".csv");
        std::error_code missing;
        const auto found = std::filesystem::file_size(path, missing);
        if (missing || found < bytes.get<std::uintmax_t>()) {
            return fmt::format("{}: must hold the {} bytes it had at the checkpoint, found {}: rows are lost; put the "
                               "file back, or run the scene anew in another folder",
                               path.string(), bytes.get<std::uintmax_t>(),
                               missing ? "no file" : fmt::format("{}", found));
        }
    }
    return {};
}

} // namespace

void Recorder::claim(const Communicator& comm, const std::filesystem::path& folder,
                     const std::filesystem::path& samples) {
    std::string error;
    if (comm.is_root()) {
        error = make_folders(folder, samples);
        if (error.empty()) {
            std::error_code ignored;
            for (const auto serial : checkpoint_serials(folder / "checkpoints")) {
                remove_checkpoint(folder / "checkpoints", serial);
            }
            remove_results(folder);
            if (std::filesystem::is_directory(folder / "checkpoints", ignored)) { // and not a file of the user's
                std::filesystem::remove(folder / "checkpoints", ignored);
            }
            for (const auto* file : {"summary.json", "run.xdmf", "contacts.xdmf", "scene.toml"}) {
                std::filesystem::remove(folder / file, ignored);
            }
            Measurer::forget(folder / "measures");
        }
    }
    comm.throw_together<SystemError>(error);
}

void Recorder::reclaim(const Communicator& comm, const std::filesystem::path& folder,
                       const nlohmann::ordered_json& course, const std::filesystem::path& samples) {
    std::string error;
    if (comm.is_root()) {
        const bool loading = course.at("loading").get<bool>();
        error = loading ? lost_rows(folder, course.at("recorder").at("series")) : std::string();
        if (error.empty()) {
            error = make_folders(folder, loading ? std::filesystem::path() : samples);
        }
        if (error.empty()) {
            std::error_code ignored;
            std::filesystem::remove(folder / "summary.json", ignored);
        }
    }
    comm.throw_together<SystemError>(error);
}

nlohmann::ordered_json Recorder::state() {
    nlohmann::ordered_json json;
    auto& cells = json["cells"] = nlohmann::ordered_json::array();
    for (const auto& cell : initial_) {
        cells.push_back({cell.grains, exact(cell.volume), exact(cell.extent[0]), exact(cell.extent[1])});
    }
    json["bed"] = exact(bed_);
    json["wall_work"] = exact(wall_work_);
    json["initial_kinetic"] = exact(initial_kinetic_);
    json["largest_overlap"] = exact(largest_overlap_);
    json["largest_residual"] = exact(largest_residual_);
    json["sensors"] = sensors_->state();
    auto& frames = json["frames"] = nlohmann::ordered_json::array();
    for (std::size_t k = 0; k < index_.entries().size(); ++k) {
        const auto& entry = index_.entries()[k];
        frames.push_back({frame_steps_[k], exact(entry.time), entry.n_grains, entry.n_contacts});
    }
    auto& series = json["series"] = nlohmann::ordered_json::object();
    for_each_series([&](const std::string& name, SeriesWriter& writer) {
        writer.sync();
        series[name] = writer.bytes();
    });
    share_errors();
    std::string text = json.dump();
    simulation_.comm().broadcast(text);
    return nlohmann::ordered_json::parse(text);
}

void Recorder::resume(const nlohmann::ordered_json& state) {
    for (const auto& cell : state.at("cells")) {
        CellShape<2> shape;
        shape.grains = cell.at(0).get<std::int64_t>();
        shape.volume = from_exact(cell.at(1));
        shape.extent = Vec<2>(from_exact(cell.at(2)), from_exact(cell.at(3)));
        initial_.push_back(shape);
    }
    bed_ = from_exact(state.at("bed"));
    wall_work_ = from_exact(state.at("wall_work"));
    initial_kinetic_ = from_exact(state.at("initial_kinetic"));
    largest_overlap_ = from_exact(state.at("largest_overlap"));
    largest_residual_ = from_exact(state.at("largest_residual"));
    overlaps_ = overlaps(simulation_);
    std::vector<FrameEntry> entries;
    for (const auto& frame : state.at("frames")) {
        frame_steps_.push_back(frame.at(0).get<std::int64_t>());
        entries.push_back({from_exact(frame.at(1)), frame_name(frame_steps_.back()), frame.at(2).get<std::int64_t>(),
                           frame.at(3).get<std::int64_t>()});
    }
    index_.resume(simulation_.comm(), std::move(entries));
    if (simulation_.comm().is_root()) { // frames of later steps would pass for this run's
        std::set<std::filesystem::path> ours;
        for (const auto step : frame_steps_) {
            ours.insert(folder_ / frame_name(step));
        }
        std::vector<std::filesystem::path> later;
        std::error_code ignored;
        for (const auto& entry : std::filesystem::directory_iterator(folder_ / "frames", ignored)) {
            const auto name = entry.path().filename().string();
            if (name.starts_with("frame-") && name.ends_with(".hdf") && !ours.contains(entry.path())) {
                later.push_back(entry.path());
            }
        }
        for (const auto& path : later) {
            std::filesystem::remove(path, ignored);
        }
    }
    write_scene();
}

/// Measures follow from frames: those that there are, are measured once more, to the same bits.
void Recorder::measure_again() {
    std::vector<std::string> walls;
    for (const auto& wall : simulation_.scene().walls) {
        walls.push_back(wall.name);
    }
    for (const auto step : frame_steps_) {
        measurer_->measure(read_frame<2>(simulation_.comm(), folder_ / frame_name(step), step, walls));
    }
}

} // namespace nappe
