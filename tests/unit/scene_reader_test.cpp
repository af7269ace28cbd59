// The scene file: every key arrives in its field, every rule gives its message, overrides, the jobs of the repository.
#include "bad_scenes.hpp"
#include "scene_examples.hpp"
#include "scene_fields.hpp"

#include "core/error.hpp"
#include "io/scene_reader.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace nappe {
namespace {

using test::fields;
using test::sound_scene;

const std::string source_dir = NAPPE_SOURCE_DIR;

std::string error_of(std::string_view text, const std::vector<std::string>& overrides = {}) {
    try {
        parse_scene(text, "bad.toml", overrides);
    } catch (const InputError& error) {
        return error.what();
    }
    return "accepted";
}

std::string file_error(const std::string& path) {
    try {
        read_scene(path);
    } catch (const InputError& error) {
        return error.what();
    }
    return "accepted";
}

TEST(scene_reader, every_key_arrives_in_its_field) {
    const auto scene = parse_scene(sound_scene, "good.toml");
    Scene<2> expected;
    expected.title = "box of disks";
    expected.gravity = {0, -9.81};
    expected.origin = {-1.5, 0}; // positions of a scene are relative to it: 1.5 m more than the file has along x
    expected.materials = {{"wall", 0}, {"rock", 2800}, {"steel", 0}};
    expected.laws = {{1, 1, 0.4, 0}, {2, 1, 0.3, 0.5}, {1, 0, 0, 0}};
    expected.sample = Sample<2>{.material = 1,
                                .radii = {RadiusLaw::Kind::uniform, 0.42, 0.56},
                                .profile = {{1.5, 0}, {21.5, 0}, {21.5, 5}, {9.5, 5}, {6.5, 10}, {1.5, 10}},
                                .layer_tops = {1.5, 3, 4.5},
                                .seed = 7};
    SingleGrain<2> grain{.material = 1, .radius = 0.5, .position = {11.5, 12}, .velocity = {0, -1}, .layer = 4};
    grain.spin[0] = 2.5;
    expected.grains = {grain};
    expected.walls = {
        {"floor", 0, {{1.5, 0}, {21.5, 0}}, std::nullopt},
        {"piston", 2, {{1.5, 20}, {1.5, 0}}, Motion<2>{.velocity = {0.5, 0}, .stage = 1, .stop = 8}},
        {"lid", 0, {{26.5, 0}, {26.5, 30}}, Motion<2>{.velocity = {0, 0.1}, .start = 2, .stop = {}}},
    };
    const SolverSettings base{
        .h = 0.025, .substeps = 2, .theta = 0.6, .sweeps = 80, .tolerance = 1e-5, .max_sweeps = 500, .check_every = 20};
    auto settling = base;
    settling.h = 0.01;
    settling.sweeps = 300;
    expected.stages = {{"settle", SettleCriterion{1e-7, 1e-3, 1e-3, 50}, 0, settling},
                       {"push", std::nullopt, 10, base}};
    expected.output = {40,
                       5,
                       {{"W1", {4.5, 3}, 2}, {"W2", {10.5, 2}, 1.5}},
                       {{"slab", 0, 2, 20, 9, 3}, {"shove", 1, 0, 20, 1, 0}},
                       {{"one", 12345678901, 7, ""}, {"two", 0, 0, ""}},
                       1.5,
                       {true, 2, 4, true},
                       {{1, {7.5, 0.5}, 0.2}}};
    expected.tiles = {8, 0.05, 4, 1.5};
    expected.balance = {1.1, 100, BalanceSettings::By::time, BalanceSettings::Moves::always};
    using Then = WatchSettings<2>::Then;
    expected.watch = {{0.2, Then::substep}, {0.05, Then::stop}, {3, Then::stop}, {}, Then::substep, 16};
    expected.watch.bounds = {{0.5, -2}, {31.5, 40}, Then::warn}; // from the origin, as all positions are
    EXPECT_EQ(fields(scene), fields(expected));
}

TEST(scene_reader, what_is_left_out_has_the_defaults_of_the_model) {
    const auto scene = parse_scene(R"(
materials.rock.density = 1
laws = [{ between = ["rock", "rock"], type = "frictional", friction = 0 }]
grains = [{ material = "rock", radius = 1, position = [0, 0] }]
stages = [{ name = "fall", duration = 1 }]
solver.h = 0.1)",
                                   "least.toml");
    Scene<2> expected;
    expected.materials = {{"wall", 0}, {"rock", 1}};
    expected.laws = {{1, 1, 0, 0}};
    expected.grains = {{.material = 1, .radius = 1}};
    expected.stages = {{.name = "fall", .until = {}, .duration = 1, .solver = {.h = 0.1, .tolerance = {}}}};
    EXPECT_EQ(fields(scene), fields(expected));
}

/// What a scene says of places is relative to its origin, and refused where doubles of the file are too coarse.
TEST(scene_reader, origin_far_away) {
    const auto scene_at = [](const char* x) {
        return fmt::format(R"(
world.origin = [{0}, 0]
materials.rock.density = 1
laws = [{{ between = ["rock", "rock"], type = "frictional", friction = 0 }}]
grains = [{{ material = "rock", radius = 0.5, position = [{0}.5, 2] }}]
stages = [{{ name = "fall", duration = 1 }}]
solver.h = 0.1)",
                           x);
    };
    for (const char* x : {"0", "1000000", "1000000000", "4294967295"}) {
        const auto scene = parse_scene(scene_at(x), "far.toml");
        EXPECT_EQ(scene.grains[0].position, Vec<2>(0.5, 2)) << x;
    }
    EXPECT_EQ(error_of(scene_at("5000000000")),
              "bad.toml:2: world.origin: must lie within 2^33 smallest radii (4.29497e+09 m) of [0, 0], found "
              "[5000000000, 0]; give coordinates from a nearer point");
}

TEST(scene_reader, constant_radius_and_layers_by_their_tops) {
    const auto scene = parse_scene(sound_scene, "good.toml",
                                   {"sample.radius={ law = \"constant\", value = 0.5 }", "sample.layers=[1, 2.5]"});
    EXPECT_EQ(scene.sample->radii.kind, RadiusLaw::Kind::constant);
    EXPECT_EQ(scene.sample->radii.min, 0.5);
    EXPECT_EQ(scene.sample->radii.max, 0.5);
    EXPECT_EQ(scene.sample->layer_tops, (std::vector<double>{1, 2.5}));
}

TEST(scene_reader, scene_as_run_parses_to_the_same_scene) {
    // Overrides of every kind, and numbers whose shortest decimals are not exact in binary.
    const std::vector<std::string> overrides = {"solver.h=0.1",
                                                "walls.lid.points=[[30,0.1],[30,0.3]]",
                                                "tiles.side=9.7",
                                                "stages.push.solver.sweeps=123",
                                                "output.cells.W2.radius=0.7",
                                                "title=\"it's \\\"quoted\\\" – ü\""};
    const auto first = parse_scene(sound_scene, "good.toml", overrides);
    const auto second = parse_scene(first.text, "scene.toml");
    EXPECT_EQ(fields(first), fields(second));
    EXPECT_EQ(first.text, second.text);
}

TEST(scene_reader, overrides_reach_tables_named_elements_and_indices) {
    const auto scene = parse_scene(sound_scene, "good.toml",
                                   {"walls.piston.motion.velocity=[1,0]", "stages.push.duration=20",
                                    "laws.0.friction=0.2", "output.cells.W2.radius=3", "solver.tolerance=1e-6",
                                    "stages.push.solver.sweeps=7", "world.gravity.1=-1.62", "solver.method=nsgs",
                                    "title=box", "tiles.side = 9", "solver.h=0.5", "solver.h=0.05"});
    EXPECT_EQ(scene.walls[1].motion->velocity, Vec<2>(1, 0));
    EXPECT_EQ(scene.walls[1].motion->stage, 1) << "the rest of the table must stay";
    EXPECT_EQ(scene.stages[1].duration, 20);
    EXPECT_EQ(scene.laws[0].friction, 0.2);
    EXPECT_EQ(scene.output.cells[1].radius, 3);
    EXPECT_EQ(scene.stages[1].solver.tolerance, 1e-6);
    EXPECT_EQ(scene.stages[1].solver.sweeps, 7);
    EXPECT_EQ(scene.stages[0].solver.sweeps, 300);
    EXPECT_EQ(scene.gravity, Vec<2>(0, -1.62));
    EXPECT_EQ(scene.title, "box") << "a bare word is a string";
    EXPECT_EQ(scene.tiles.side, 9);
    EXPECT_EQ(scene.stages[1].solver.h, 0.05) << "the last of two counts";
}

TEST(scene_reader, an_override_creates_a_table_that_the_file_leaves_out) {
    std::string text(sound_scene);
    text.erase(text.find("[balance]"), text.find("[output]") - text.find("[balance]"));
    EXPECT_EQ(parse_scene(text, "good.toml").balance.every, BalanceSettings{}.every);
    EXPECT_EQ(parse_scene(text, "good.toml", {"balance.every=7"}).balance.every, 7);
}

TEST(scene_reader, the_last_grain_may_be_probed_and_no_later_one) {
    const auto probed = [](std::string_view grain) {
        return parse_scene(sound_scene, "good.toml",
                           {"sample.arrangement=square", "sample.radius={ law = \"constant\", value = 0.5 }",
                            "sample.profile=[[0,0],[20,0],[20,10],[0,10]]", // 200 disks
                            fmt::format("output.probes.one.grain={}", grain)})
            .output.probes[0];
    };
    EXPECT_EQ(probed("200").grain, 200) << "the single grain";
    EXPECT_EQ(probed("-201").grain, -201);
    EXPECT_THROW(probed("201"), InputError);
    EXPECT_THROW(probed("-202"), InputError);
    EXPECT_EQ(probed("0").place, "--set output.probes.one.grain=0: output.probes.one.grain");
    EXPECT_EQ(parse_scene(sound_scene, "good.toml").output.probes[0].place, "good.toml:99: output.probes.one.grain");
}

class BadScenes : public testing::TestWithParam<test::BadScene> {};

TEST_P(BadScenes, give_their_message) {
    const auto& bad = GetParam();
    std::string text(sound_scene);
    const std::string find = bad.find;
    if (!find.empty()) {
        const auto at = text.find(find);
        ASSERT_NE(at, std::string::npos) << "the edit no longer applies";
        ASSERT_EQ(text.find(find, at + 1), std::string::npos) << "the edit is ambiguous";
        text.replace(at, find.size(), bad.replace);
    }
    EXPECT_EQ(error_of(text, bad.overrides), bad.message);
}

INSTANTIATE_TEST_SUITE_P(scene_reader, BadScenes, testing::ValuesIn(test::bad_scenes),
                         [](const auto& row) { return std::string(row.param.name); });

TEST(scene_reader, more_than_64_cells_are_refused_and_64_are_not) {
    std::string cells;
    for (int k = 0; k < 64; ++k) {
        cells += fmt::format("{{ name = \"c{}\", centre = [1, 1], radius = 1 }},", k);
    }
    EXPECT_EQ(parse_scene(sound_scene, "good.toml", {"output.cells=[" + cells + "]"}).output.cells.size(), 64u);
    const auto error =
        error_of(sound_scene, {"output.cells=[" + cells + "{ name = \"last\", centre = [1, 1], radius = 1 }]"});
    EXPECT_NE(error.find("output.cells: must be at most 64, found an array of 65 values"), std::string::npos) << error;
}

TEST(scene_reader, walls_and_grains_may_touch_the_profile) {
    // Along an edge, across a corner without entering, and a grain that just clears the top at y = 5.
    const auto on_edge = "walls.lid.points=[[20, -3], [20, 30]]";
    const auto at_corner = "walls.lid.points=[[18, 7], [22, 3]]";
    const auto resting = "grains.0.position=[12, 5.5]";
    for (const auto* edit : {on_edge, at_corner, resting}) {
        EXPECT_EQ(error_of(sound_scene, {edit}), "accepted") << edit;
    }
    // A millimetre further in, each is refused.
    for (const auto* edit : {"walls.lid.points=[[19.999, -3], [19.999, 30]]",
                             "walls.lid.points=[[18, 6.999], [22, 2.999]]", "grains.0.position=[12, 5.499]"}) {
        EXPECT_NE(error_of(sound_scene, {edit}).find("out of sample.profile"), std::string::npos) << edit;
    }
}

TEST(scene_reader, a_profile_of_one_grain_is_wide_enough) {
    // Radii 0.42 to 0.56 m: 1.12 m holds the largest, 1.11 m is 1 % short of it.
    const auto strip = [](double width) {
        return fmt::format("sample.profile=[[0,0],[20,0],[20,{0}],[0,{0}]]", width);
    };
    EXPECT_EQ(error_of(sound_scene, {strip(1.12)}), "accepted");
    EXPECT_NE(error_of(sound_scene, {strip(1.11)}).find("must have room for a grain"), std::string::npos);
}

TEST(scene_reader, files_that_are_no_scenes) {
    const auto folder = std::filesystem::temp_directory_path() /
                        fmt::format("nappe_scene_{}", testing::UnitTest::GetInstance()->random_seed());
    std::filesystem::create_directories(folder);
    const auto empty = (folder / "empty.toml").string();
    std::ofstream(empty) << " \n";
    EXPECT_EQ(file_error(folder.string()),
              folder.string() + ": must be a scene file, found a directory; name the .toml file in it");
    EXPECT_EQ(file_error((folder / "none.toml").string()),
              (folder / "none.toml").string() +
                  ": must be a readable scene file, found: No such file or directory; check the path");
    EXPECT_EQ(file_error(empty), empty + ": must hold a scene, found an empty file; docs/scene.md has an example");
    std::filesystem::remove_all(folder);
}

/// Input that takes a program down by its size alone is refused, with a short message, whatever its form.
TEST(scene_reader, endless_input_is_refused_with_its_number) {
    EXPECT_EQ(file_error("/dev/zero"),
              "/dev/zero: must be a scene file of at most 64 MiB, found more; is it the right file?");
    const auto repeated = [](std::string_view piece, int times) {
        std::string text;
        for (int k = 0; k < times; ++k) {
            text += piece;
        }
        return text;
    };
    const auto expect_part = [](const std::string& error, std::string_view part) {
        EXPECT_NE(error.find(part), std::string::npos) << error.substr(0, 1000);
        EXPECT_LT(error.size(), 20 * 2000u); // 20 problems of a screenful each
    };
    const int many = 300000;
    expect_part(error_of("x" + repeated(".x", many) + " = 1"), "bad.toml:1: must have at most 32 dots in a key");
    expect_part(error_of("x = " + repeated("[", many)), "bad.toml:1: must be valid TOML, found: ");
    expect_part(error_of("x = " + repeated("{ x = ", many)), "bad.toml:1: must be valid TOML, found: ");
    expect_part(error_of(repeated("[[walls]]\n", many)),
                "walls: must hold at most 1000 tables, found an array of 300000");
    expect_part(error_of(repeated("[[grains]]\nname = \"a\"\n", many)), "grains: must hold at most 100000 tables");
    expect_part(error_of(repeated("[[grains]]\nname = \"a\"\n", 90000)), "… and ");
    expect_part(error_of(std::string(many, 'k') + " = 1"), "kkk…: unknown key; must be one of those of the top level");
    expect_part(error_of("title = \"" + std::string(many, 't') + "\""), "ttt…\"; one line for pictures");
    expect_part(error_of(sound_scene, {"sample.profile=[" + repeated("[0, 0],", 5000) + "]"}),
                "sample.profile: must have at most 4096 points, found 5000");
    expect_part(error_of(sound_scene, {"walls.lid.points=[" + repeated("[30, 0], [30, 1],", 9000) + "]"}),
                "walls: must have at most 16384 points together, found 18004");
    expect_part(error_of(sound_scene, {repeated("solver.", many) + "h=1"}), "must be KEY=VALUE with a dotted KEY");
    expect_part(error_of(sound_scene, {"solver.h=" + repeated("[", many)}), "the value must be TOML on one line");
}

TEST(scene_reader, the_small_fold_is_the_fold_at_quarter_scale) {
    const auto fold = read_scene(source_dir + "/jobs/fold.toml");
    auto scaled = read_scene(source_dir + "/jobs/fold-small.toml");
    scaled.title = fold.title;
    for (auto& p : scaled.sample->profile) {
        p *= 4;
    }
    for (auto& top : scaled.sample->layer_tops) {
        top *= 4;
    }
    for (auto& wall : scaled.walls) {
        for (auto& p : wall.points) {
            p *= 4;
        }
    }
    for (auto& cell : scaled.output.cells) {
        cell.centre *= 4;
        cell.radius *= 4;
    }
    for (auto& stage : scaled.stages) {
        stage.duration *= 4;
    }
    EXPECT_EQ(fields(scaled), fields(fold));
}

TEST(scene_reader, watch_has_defaults_and_takes_overrides) {
    using Then = WatchSettings<2>::Then;
    const std::string text(sound_scene.substr(0, sound_scene.find("[watch]")));
    const auto plain = parse_scene(text, "good.toml").watch;
    EXPECT_EQ(plain.overlap.limit, 0.8);
    EXPECT_EQ(plain.overlap.then, Then::warn);
    EXPECT_EQ(plain.energy.limit, 0.1);
    EXPECT_EQ(plain.residual.steps, 10);
    EXPECT_FALSE(plain.bounds);
    EXPECT_EQ(plain.failure, Then::stop);
    EXPECT_EQ(plain.max_substeps, 64);
    const auto set = parse_scene(text, "good.toml", {"watch.overlap.limit=0.3", "watch.energy.do=stop"}).watch;
    EXPECT_EQ(set.overlap.limit, 0.3);
    EXPECT_EQ(set.overlap.then, Then::warn);
    EXPECT_EQ(set.energy.then, Then::stop);
}

TEST(scene_reader, cohesion_of_a_law_or_else_of_its_materials) {
    const auto law = [](const std::vector<std::string>& overrides, std::size_t k) {
        return parse_scene(sound_scene, "sound.toml", overrides).laws[k];
    };
    const std::vector<std::string> of_rock = {"materials.rock.gamma=1e3", "materials.rock.d_w=0.01",
                                              "laws.0.type=cohesive", "laws.2.type=cohesive"};
    EXPECT_EQ(law(of_rock, 0).gamma, 1e3);
    EXPECT_EQ(law(of_rock, 0).d_w, 0.01);
    EXPECT_EQ(law(of_rock, 2).gamma, 1e3) << "with walls too, which say nothing themselves";
    EXPECT_EQ(law(of_rock, 1).gamma, 0) << "a frictional law has none, whatever its materials say";
    auto own = of_rock;
    own.insert(own.end(), {"laws.2.gamma=5", "laws.2.d_w=0.5"});
    EXPECT_EQ(law(own, 2).gamma, 5);
    EXPECT_EQ(law(own, 2).range(), 0.5);
    own.push_back("laws.2.gamma=0");
    EXPECT_EQ(law(own, 2).range(), 0) << "without an attraction there is no range";
}

} // namespace
} // namespace nappe
