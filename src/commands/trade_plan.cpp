#include "commands/trade_plan.hpp"

#include "commands/prepare.hpp"
#include "core/error.hpp"
#include "io/scene_reader.hpp"
#include "io/summary.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>

namespace nappe {

namespace {

const Stage* first_loading(const Scene<2>& scene) {
    const auto found =
        std::find_if(scene.stages.begin(), scene.stages.end(), [](const Stage& stage) { return !stage.until; });
    return found == scene.stages.end() ? nullptr : &*found;
}

/// Of loading, up to `duration`.
std::int64_t steps_of(const Scene<2>& scene, const std::optional<double>& duration) {
    std::int64_t steps = 0;
    double left = duration.value_or(std::numeric_limits<double>::infinity());
    for (const auto& stage : scene.stages) {
        if (!stage.until && left > 0) {
            const bool whole = stage.duration <= left;
            steps += whole ? n_steps(stage) : std::max<std::int64_t>(1, std::llround(left / stage.solver.h));
            left -= stage.duration;
        }
    }
    return steps;
}

/// What every setting has in common, before its own keys.
std::vector<SceneOverride> common_overrides(const std::vector<std::string>& overrides, const Scene<2>& plain,
                                            std::int64_t seed) {
    std::vector<SceneOverride> keys;
    keys.reserve(overrides.size());
    for (const auto& text : overrides) {
        keys.push_back({text, ""});
    }
    if (plain.sample) {
        keys.push_back({fmt::format("sample.seed={}", seed), ""});
    }
    keys.push_back({"output.measures.during_run=true", ""});
    keys.push_back({"output.measures.energy=true", ""});
    return keys;
}

/// The setting's keys. Preparing stages keep the scene's: every setting starts from the same sample.
void add_setting(const TradeSetting& setting, const Scene<2>& plain, std::vector<SceneOverride>& keys) {
    for (std::size_t s = 0; s < plain.stages.size(); ++s) {
        if (plain.stages[s].until) {
            continue;
        }
        for (const auto& key : setting.solver) {
            keys.push_back(
                {fmt::format("stages.{}.solver.{}={}", plain.stages[s].name, key.key, key.value), key.place});
        }
    }
    for (const auto& key : setting.set) {
        keys.push_back({key.key + "=" + key.value, key.place});
    }
}

/// Rows and frames at the times at which the scene has them, whatever the step: what is averaged over intervals, and
/// what is the largest of all rows, is then the same for all settings.
void add_output(const TradeSetting& setting, const TradeMatrix& matrix, const Scene<2>& plain, const Scene<2>& scene,
                std::vector<SceneOverride>& keys) {
    const double ratio = first_loading(plain)->solver.h / first_loading(scene)->solver.h;
    const auto rescaled = [&](int every) { return std::max<std::int64_t>(1, std::llround(every * ratio)); };
    const auto put = [&](const std::string& key, std::int64_t every) {
        const bool said = std::any_of(setting.set.begin(), setting.set.end(),
                                      [&](const TradeKey& own) { return own.key.starts_with(key); });
        if (!said) {
            keys.push_back({fmt::format("{}.every={}", key, every), ""});
        }
    };
    put("output.series", rescaled(plain.output.series_every));
    if (matrix.frames) {
        const auto steps = steps_of(scene, matrix.duration);
        put("output.frames", std::max<std::int64_t>(1, (steps + *matrix.frames - 1) / *matrix.frames));
    } else if (plain.output.frames_every > 0) {
        put("output.frames", rescaled(plain.output.frames_every));
    }
}

/// All that must be the same for two settings to be compared: what the sample is made of, and what happens to it.
std::string course_of(const Scene<2>& scene) {
    auto text = sample_origin(scene).made_from;
    for (const auto& stage : scene.stages) {
        text += fmt::format("stage {} {}\n", stage.name, stage.duration);
    }
    for (const auto& wall : scene.walls) {
        if (wall.motion) {
            const auto& m = *wall.motion;
            text += fmt::format("motion {} [{}, {}] {} {} {}\n", wall.name, m.velocity[0], m.velocity[1], m.stage,
                                m.start, m.stop.value_or(-1));
        }
    }
    for (const auto& law : scene.laws) {
        text += fmt::format("cohesion {} {}\n", law.gamma, law.d_w);
    }
    return text;
}

/// The places already name what is wrong; only where they do not (a rule across keys), the setting is named.
std::string with_place(const std::string& problem, const TradeSetting& setting) {
    return problem.find(setting.place.substr(setting.place.rfind(' ') + 1)) != std::string::npos
               ? problem
               : fmt::format("{}: {}", setting.place, problem);
}

Scene<2> scene_of(std::string_view text, const std::string& file_name, const std::vector<std::string>& overrides,
                  const TradeMatrix& matrix, const TradeSetting& setting, const Scene<2>& plain, std::int64_t seed) {
    auto keys = common_overrides(overrides, plain, seed);
    add_setting(setting, plain, keys);
    const auto scene = parse_scene_with(text, file_name, keys);
    if (first_loading(scene) == nullptr || !(first_loading(scene)->solver.h > 0)) {
        throw InputError(fmt::format("{}: must leave the scene a stage with a duration, found none; leave stages alone",
                                     setting.place));
    }
    add_output(setting, matrix, plain, scene, keys);
    return parse_scene_with(text, file_name, keys);
}

std::vector<std::int64_t> seeds_of(const Scene<2>& plain, const TradeMatrix& matrix) {
    if (!plain.sample) {
        if (!matrix.seeds.empty()) {
            throw InputError("seeds: must be absent for a scene without [sample], found some; its grains are given one "
                             "by one, so that every seed would be the same run");
        }
        return {0};
    }
    return matrix.seeds.empty() ? std::vector{static_cast<std::int64_t>(plain.sample->seed)} : matrix.seeds;
}

nlohmann::json read_json(const std::filesystem::path& path) {
    std::ifstream file(path);
    return file ? nlohmann::json::parse(file, nullptr, false) : nlohmann::json();
}

/// Throws InputError.
void refuse_others(const nlohmann::json& json, const PlannedRun& run) {
    const char* other = json.value("scene", "") != run.scene.text                   ? "scene or setting"
                        : json.value("steps", std::int64_t{-1}) != run.steps        ? "length"
                        : json.value("version", std::string()) != program_version() ? "version of nappe"
                                                                                    : nullptr;
    if (other != nullptr) {
        throw InputError(fmt::format("{}: must be of this scene, setting, length and version, found a finished run of "
                                     "another {}; give another --out, or delete that folder",
                                     run.folder.string(), other));
    }
}

constexpr auto failure_file = "failed.json";

} // namespace

TradePlan plan_trade(std::string_view text, const std::string& file_name, const std::vector<std::string>& overrides,
                     const TradeMatrix& matrix, const std::filesystem::path& folder) {
    const auto plain = parse_scene(text, file_name, overrides);
    if (first_loading(plain) == nullptr) {
        throw InputError(fmt::format("{}: stages: must hold one with a duration, found none; there is nothing to trade "
                                     "while a sample is prepared",
                                     file_name));
    }
    TradePlan plan;
    plan.seeds = seeds_of(plain, matrix);
    std::vector<const TradeSetting*> settings{&matrix.reference};
    for (const auto& setting : matrix.settings) {
        settings.push_back(&setting);
    }
    for (const auto* setting : settings) {
        plan.names.push_back(setting->name);
    }
    for (std::size_t s = 0; s < plan.seeds.size(); ++s) {
        std::string problems, course;
        for (std::size_t k = 0; k < settings.size(); ++k) {
            const auto path = folder / "runs" / plan.names[k] / fmt::format("seed-{}", plan.seeds[s]);
            try {
                auto scene = scene_of(text, file_name, overrides, matrix, *settings[k], plain, plan.seeds[s]);
                const auto own = course_of(scene);
                course = k == 0 ? own : course;
                if (!course.empty() && own != course) {
                    throw InputError(
                        fmt::format("{}: set: must leave grains, walls, laws, tiles, durations and preparing "
                                    "stages alone, found a change of them; settings are compared on one "
                                    "scene, from one sample",
                                    settings[k]->place));
                }
                const auto steps = steps_of(scene, matrix.duration);
                plan.runs.push_back({k, s, std::move(scene), steps, path});
            } catch (const InputError& e) {
                problems += (problems.empty() ? "" : "\n") + with_place(e.what(), *settings[k]);
            }
        }
        if (!problems.empty()) {
            throw InputError(problems); // further seeds would say the same
        }
    }
    return plan;
}

RunState state_of(const PlannedRun& run) {
    const auto failed = read_json(run.folder / failure_file);
    if (failed.is_object()) {
        refuse_others(failed, run);
        return RunState::failed;
    }
    const auto summary = read_json(run.folder / "summary.json");
    if (!summary.is_object() || value_of(nlohmann::ordered_json(summary), "stopped_early", true)) {
        return RunState::to_do;
    }
    refuse_others(summary, run);
    return RunState::done;
}

void remember_failure(const PlannedRun& run, const std::string& reason) {
    write_summary(
        run.folder / failure_file,
        {{"reason", reason}, {"steps", run.steps}, {"scene", run.scene.text}, {"version", program_version()}});
}

std::string failure_of(const PlannedRun& run) {
    const auto json = read_json(run.folder / failure_file);
    return json.is_object() ? json.value("reason", "") : "";
}

} // namespace nappe
