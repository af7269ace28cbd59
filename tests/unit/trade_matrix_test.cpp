// The matrix file of nappe trade: keys, rules, the jobs of the repository, what its settings make of a scene.

#include "commands/trade.hpp"
#include "commands/trade_plan.hpp"
#include "core/error.hpp"
#include "io/scene_keys.hpp"
#include "io/scene_reader.hpp"
#include "io/summary.hpp"
#include "io/trade_matrix.hpp"
#include "scene_examples.hpp"
#include "temporary_folder.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>

namespace nappe::trade_matrix_test {
namespace {

const std::string source_dir = NAPPE_SOURCE_DIR;

constexpr std::string_view sound_matrix = R"(seeds = [1, 2]
window = 0.5
duration = 4.0
frames = 3
[reference]
solver = { substeps = 10, sweeps = 400 }
[[settings]]
name = "coarse"
solver = { h = 0.1, tolerance = 1e-3, max_sweeps = 200 }
[[settings]]
name = "odd"
solver.theta = 0.75
set = { balance.threshold = 1.5, "output.series.every" = 7 }
)";

std::string with(std::string_view text, const std::string& old, const std::string& now) {
    std::string changed(text);
    const auto at = changed.find(old);
    EXPECT_NE(at, std::string::npos) << old;
    return changed.replace(at, old.size(), now);
}

std::string error_of(const std::string& text) {
    try {
        parse_matrix(text, "m.toml");
        return "none";
    } catch (const InputError& e) {
        return e.what();
    }
}

std::string plan_error(const std::string& text, std::string_view scene = test::sound_scene) {
    try {
        plan_trade(scene, "s.toml", {}, parse_matrix(text, "m.toml"), "out");
        return "none";
    } catch (const InputError& e) {
        return e.what();
    }
}

TEST(TradeMatrix, EveryKeyArrives) {
    const auto m = parse_matrix(sound_matrix, "m.toml");
    EXPECT_EQ(m.seeds, (std::vector<std::int64_t>{1, 2}));
    EXPECT_EQ(m.window, 0.5);
    EXPECT_EQ(m.duration, 4.0);
    EXPECT_EQ(m.frames, 3);
    EXPECT_EQ(m.reference.name, "reference");
    ASSERT_EQ(m.settings.size(), 2u);
    ASSERT_EQ(m.settings[0].solver.size(), 3u);
    EXPECT_EQ(m.settings[0].solver[0].key, "h");
    EXPECT_EQ(m.settings[0].solver[0].value, "0.1");
    EXPECT_EQ(m.settings[0].solver[0].place, "m.toml:9: settings.coarse");
    ASSERT_EQ(m.settings[1].set.size(), 2u);
    EXPECT_EQ(m.settings[1].set[0].key, "balance.threshold");
    EXPECT_EQ(m.settings[1].set[1].key, "output.series.every");
}

TEST(TradeMatrix, WhatIsWrongIsSaidWithFileAndLine) {
    const std::vector<std::array<std::string, 3>> wrong = {
        {"window = 0.5", "windo = 0.5", "m.toml:2: windo: unknown key; "},
        {"window = 0.5", "window = 0", "m.toml:2: window: must lie in (0, 1], found 0"},
        {"[1, 2]", "[]", "m.toml:1: seeds: must be an array of at least one integer"},
        {"[1, 2]", "[1, -2]", "m.toml:1: seeds.1: must be an integer >= 0, found -2"},
        {"[1, 2]", "[1, 1]", "m.toml:1: seeds.1: must be listed once"},
        {"duration = 4.0", "duration = 0.0", "m.toml:3: duration: must be > 0 [s]"},
        {"frames = 3", "frames = 0", "m.toml:4: frames: must be an integer >= 1"},
        {"[reference]", "[referenz]", "m.toml: reference: is required"},
        {"name = \"coarse\"", "", "m.toml:7: settings.0.name: is required"},
        {"name = \"odd\"", "name = \"coarse\"", "must be the only setting of that name"},
        {"name = \"odd\"", "name = \"reference\"", "must not be that of the reference"},
        {"name = \"odd\"", "name = \"o/d\"", "must be 1 to 64 letters, digits, _ or -"},
        {"solver.theta = 0.75", "solver = 0.75", "m.toml:12: settings.odd.solver: must be a table"},
        {"solver.theta = 0.75", "solv = 0.75", "m.toml:12: settings.odd.solv: unknown key"},
        {"balance.threshold = 1.5", "sample.seed = 3", "must leave the sample's seed alone"},
        {"balance.threshold = 1.5", "output.cells = []", "must leave output alone"},
        {"[1, 2]", "[1, 2", "m.toml:2: must be valid TOML"},
    };
    for (const auto& [old, now, said] : wrong) {
        const auto error = error_of(with(sound_matrix, old, now));
        EXPECT_NE(error.find(said), std::string::npos) << now << "\n" << error;
    }
    EXPECT_NE(error_of("[reference]\n").find("settings: must hold at least one setting"), std::string::npos);
}

TEST(TradeMatrix, SettingsThatTheSceneRefusesAreSaidWithFileAndLine) {
    EXPECT_EQ(plan_error(std::string(sound_matrix)), "none");
    const auto unknown = plan_error(with(sound_matrix, "h = 0.1", "hh = 0.1"));
    EXPECT_EQ(unknown.find("m.toml:9: settings.coarse: stages.push.solver.hh: unknown key"), 0u) << unknown;
    const auto value = plan_error(with(sound_matrix, "h = 0.1", "h = -0.1"));
    EXPECT_EQ(value.find("m.toml:9: settings.coarse: stages.push.solver.h: must be > 0 [s], found -0.1"), 0u) << value;
    const auto path = plan_error(with(sound_matrix, "balance.threshold = 1.5", "walls.ceiling.points = []"));
    EXPECT_EQ(path.find("m.toml:13: settings.odd: walls.ceiling: must name an element of walls"), 0u) << path;
    // A rule across keys names the setting too: the scene without a tolerance has no use for its max_sweeps.
    const auto scene = with(test::sound_scene, "tolerance = 1e-5\nmax_sweeps = 500\ncheck_every = 20\n", "");
    const auto idle = plan_error(with(sound_matrix, "tolerance = 1e-3, ", ""), scene);
    EXPECT_EQ(idle.find("m.toml:9: settings.coarse: stages.push.solver.max_sweeps: must be absent"), 0u) << idle;
}

TEST(TradeMatrix, SettingsMustLeaveTheSceneAlone) {
    for (const std::string change :
         {"laws.0.friction = 0.1", "stages.settle.solver.h = 0.02", "stages.push.duration = 9", "tiles.skin = 0.4",
          "walls.piston.motion.velocity = [1, 0]", "sample.radius.max = 0.6"}) {
        const auto error = plan_error(with(sound_matrix, "balance.threshold = 1.5", change));
        EXPECT_EQ(error.find("m.toml:10: settings.odd: set: must leave grains, walls"), 0u) << change << "\n" << error;
    }
}

TEST(TradePlan, SettingsChangeLoadingStagesOnly) {
    const auto matrix = parse_matrix(sound_matrix, "m.toml");
    const auto plan = plan_trade(test::sound_scene, "s.toml", {"title=traded"}, matrix, "out");
    const auto plain = parse_scene(test::sound_scene, "s.toml");
    ASSERT_EQ(plan.runs.size(), 6u); // seed by seed, the reference first
    EXPECT_EQ(plan.runs[3].setting, 0u);
    EXPECT_EQ(plan.runs[3].seed, 1u);
    EXPECT_EQ(plan.runs[4].folder, std::filesystem::path("out/runs/coarse/seed-2"));
    const auto& coarse = plan.runs[1].scene;
    EXPECT_EQ(coarse.title, "traded");
    EXPECT_EQ(coarse.sample->seed, 1u);
    EXPECT_TRUE(coarse.output.measures.energy && coarse.output.measures.during_run);
    for (std::size_t s = 0; s < plain.stages.size(); ++s) {
        const auto& solver = coarse.stages[s].solver;
        EXPECT_EQ(solver.h, plain.stages[s].until ? plain.stages[s].solver.h : 0.1);
        EXPECT_EQ(solver.sweeps, plain.stages[s].solver.sweeps); // what a setting leaves out is the scene's
    }
}

/// Rows and frames fall on the same times whatever the step, up to whole steps.
TEST(TradePlan, RowsAndFramesKeepTheirTimes) {
    const auto matrix = parse_matrix(sound_matrix, "m.toml");
    const auto plan = plan_trade(test::sound_scene, "s.toml", {}, matrix, "out");
    const auto plain = parse_scene(test::sound_scene, "s.toml");
    const auto h = [](const Scene<2>& scene) {
        return std::find_if(scene.stages.begin(), scene.stages.end(), [](const auto& s) { return !s.until; })->solver.h;
    };
    const double between = plain.output.series_every * h(plain);
    const auto& coarse = plan.runs[1];
    EXPECT_NEAR(coarse.scene.output.series_every * h(coarse.scene), between, 0.5 * h(coarse.scene));
    EXPECT_EQ(plan.runs[2].scene.output.series_every, 7); // its own
    EXPECT_EQ(coarse.steps, 40);                          // 4 s of 0.1 s
    EXPECT_EQ(coarse.scene.output.frames_every, 14);      // three in 40 steps
}

TEST(TradePlan, AFinishedRunIsDoneAndAnotherScenesRunIsRefused) {
    const test::TemporaryFolder folder;
    const auto matrix = parse_matrix(sound_matrix, "m.toml");
    const auto plan = plan_trade(test::sound_scene, "s.toml", {}, matrix, folder.path());
    const auto& run = plan.runs[1];
    EXPECT_EQ(state_of(run), RunState::to_do);
    std::filesystem::create_directories(run.folder);
    const auto leave = [&](const nlohmann::json& summary) { std::ofstream(run.folder / "summary.json") << summary; };
    leave({{"scene", run.scene.text}, {"steps", 20}, {"stopped_early", true}});
    EXPECT_EQ(state_of(run), RunState::to_do);
    const nlohmann::json whole = {
        {"scene", run.scene.text}, {"steps", run.steps}, {"version", program_version()}, {"stopped_early", false}};
    leave(whole);
    EXPECT_EQ(state_of(run), RunState::done);
    for (const auto& other : {nlohmann::json{{"steps", 20}}, {{"scene", "another"}}, {{"version", "0.0.1"}}}) {
        auto of_another = whole;
        of_another.update(other);
        leave(of_another);
        EXPECT_THROW(state_of(run), InputError) << other;
    }
    std::filesystem::remove(run.folder / "summary.json");
    remember_failure(run, "a grain left");
    EXPECT_EQ(state_of(run), RunState::failed);
    EXPECT_EQ(failure_of(run), "a grain left");
}

TEST(TradeMatrix, TheRepositorysAreSoundForTheirScenes) {
    const auto plan = [&](const std::string& scene, const std::string& text, std::vector<std::string> overrides = {}) {
        const auto name = source_dir + "/jobs/" + scene;
        return plan_trade(read_scene_text(name), name, overrides, parse_matrix(text, "matrix"), "out");
    };
    const std::vector<std::string> cohesive = {"materials.rock.gamma=1e4"};
    const auto file = [&](const std::string& name) { return read_matrix_text(source_dir + "/jobs/" + name); };
    EXPECT_EQ(plan("fold-small.toml", file("trade-fold.toml")).seeds.size(), 8u);
    EXPECT_GT(plan("fault.toml", file("trade-fault.toml"), cohesive).runs.size(), 1u);
    EXPECT_GT(plan("fault.toml", file("trade-default.toml"), cohesive).runs.size(), 1u);
    EXPECT_GT(plan("fault.toml", file("trade-fault-quiet.toml")).runs.size(), 1u);
    EXPECT_GT(plan("column.toml", file("trade-frictional.toml")).runs.size(), 1u);
    EXPECT_EQ(default_matrix(), file("trade-default.toml"));
    for (const auto* scene : {"fold.toml", "fold-small.toml", "fault.toml", "column.toml", "pile.toml"}) {
        EXPECT_GT(plan(scene, file("trade-default.toml")).runs.size(), 1u);
    }
}

/// docs/accuracy.md lists each key of the matrix under its table, and no other.
TEST(TradeMatrix, DocumentationListsItsKeys) {
    std::ifstream file(source_dir + "/docs/accuracy.md");
    std::vector<std::string> documented, known;
    std::string table;
    for (std::string line; std::getline(file, line);) {
        const auto open = line.find('`'), close = line.find('`', open + 1);
        const auto code = close == std::string::npos ? "" : line.substr(open + 1, close - open - 1);
        const auto& tables = scene_file::matrix_keys();
        if (line.starts_with("#")) {
            const bool ours = std::any_of(tables.begin(), tables.end(), [&](const auto& t) { return t.table == code; });
            table = ours ? code : "";
        } else if (line.starts_with("| `") && !table.empty()) {
            documented.push_back(table + " " + code);
        }
    }
    for (const auto& keys : scene_file::matrix_keys()) {
        for (const auto& key : keys.keys) {
            known.push_back(std::string(keys.table) + " " + std::string(key));
        }
    }
    std::sort(known.begin(), known.end());
    std::sort(documented.begin(), documented.end());
    EXPECT_EQ(documented, known);
}

} // namespace
} // namespace nappe::trade_matrix_test
