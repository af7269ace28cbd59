#include "commands/measure.hpp"

#include "commands/measurer.hpp"
#include "io/frame_reader.hpp"
#include "io/progress.hpp"
#include "io/scene_reader.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace nappe {

namespace {

/// Throws InputError.
void check_overrides(const std::vector<std::string>& overrides) {
    for (const auto& text : overrides) {
        if (!text.starts_with("output.measures") && !text.starts_with("output.zone")) {
            throw InputError(fmt::format("--set {}: must be of output.measures or output.zone, since all else has been "
                                         "run; leave it away, or run the scene with it",
                                         text));
        }
    }
}

/// The scene as run: scene.toml, which a run writes when its loading starts, or else what an older one left in its
/// summary. Local. Throws InputError.
std::string scene_as_run(const std::filesystem::path& folder) {
    const auto path = folder / "scene.toml";
    if (std::filesystem::exists(path)) {
        return read_scene_text(path.string());
    }
    const auto summary = folder / "summary.json";
    std::ifstream file(summary);
    const auto json = nlohmann::json::parse(file, nullptr, false);
    const auto scene = json.is_object() ? json.find("scene") : json.end();
    if (!json.is_object() || scene == json.end() || !scene->is_string()) {
        throw InputError(
            fmt::format("{}: must hold the scene as run, or {} must in its key 'scene'; found neither. Give the "
                        "folder that a run wrote, its --out; for an unfinished run of a version that left no "
                        "scene.toml, copy the scene file there",
                        path.string(), summary.string()));
    }
    return scene->get<std::string>();
}

Scene<2> shared_scene(const Communicator& comm, const MeasureOptions& options) {
    std::string text, error;
    if (comm.is_root()) {
        try {
            text = scene_as_run(options.run);
        } catch (const InputError& e) {
            error = e.what();
        }
    }
    comm.throw_together<InputError>(error);
    comm.broadcast(text);
    return parse_scene(text, (options.run / "scene.toml").string(), options.overrides);
}

} // namespace

ExitCode measure(const Communicator& comm, const MeasureOptions& options) {
    check_overrides(options.overrides); // the same on all ranks
    const auto scene = shared_scene(comm, options);
    const auto steps = stored_frames(comm, options.run);
    std::vector<std::string> walls;
    for (const auto& wall : scene.walls) {
        walls.push_back(wall.name);
    }
    if (steps.front() != 0) {
        throw InputError(
            fmt::format("{}: must list the frame of step 0, with which all later ones are compared; found step "
                        "{} first. Run the scene again",
                        (options.run / "run.xdmf").string(), steps.front()));
    }
    Measurer measurer(comm, scene, options.out.empty() ? options.run / "measures" : options.out);
    Progress progress(Progress::for_rank(comm.is_root()));
    progress.info(fmt::format("{}: {} frames, {} ranks", scene.title, steps.size(), comm.size()));
    for (const auto step : steps) {
        measurer.measure(read_frame<2>(comm, options.run / frame_name(step), step, walls));
    }
    measurer.finish();
    return ExitCode::done;
}

} // namespace nappe
