// The estimates of `nappe check`, against counts by hand.
#include "commands/check.hpp"

#include "scene_examples.hpp"

#include "io/scene_reader.hpp"
#include "solver/fields.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numbers>

namespace nappe {
namespace {

/// 100 m² of disks of radius 0.5 m, 300 steps of 60 sweeps in 3 substeps (each 20), after a stage that settles.
Scene<2> square() {
    return parse_scene(test::sound_scene, "good.toml",
                       {"sample.radius={ law = \"constant\", value = 0.5 }",
                        "sample.profile=[[0,0],[10,0],[10,10],[0,10]]", "grains=[]",
                        "solver={ h = 0.01, sweeps = 60, substeps = 3 }", "stages.push.duration=3",
                        "walls.piston.motion.stop=2", "output.frames.every=40"});
}

TEST(check, estimates_follow_from_the_scene) {
    const CostModel cost{.ns_per_relaxation = 10, .frame_bytes_per_grain = 80, .frame_bytes_per_contact = 40};
    const auto scene = square();
    const auto e = estimate(scene, cost);
    const auto grain = static_cast<double>(bytes_per_grain(features_of(scene)));
    const auto contact = static_cast<double>(bytes_per_contact(features_of(scene)));
    const double grains = 83 / (std::numbers::pi * 0.25);
    const double round_off = 1e-12; // a handful of products and quotients
    EXPECT_NEAR(e.grains / grains, 1, round_off);
    EXPECT_NEAR(e.contacts / (2.1 * grains), 1, round_off);
    EXPECT_NEAR(e.memory / (grains * (grain + contact * 2.9)), 1, round_off);
    EXPECT_EQ(e.loading_steps, 300) << "settling does not count";
    EXPECT_NEAR(e.relaxations / (2.1 * grains * 300 * 60), 1, round_off);
    EXPECT_NEAR(e.seconds / (1e-8 * e.relaxations), 1, round_off);
    EXPECT_EQ(e.frames, 9) << "the first, 40, 80 … 280, and the last";
    EXPECT_NEAR(e.disk / (9 * grains * (80 + 40 * 2.1)), 1, round_off);
}

TEST(check, sweeps_are_divided_among_substeps_and_rounded_up) {
    auto scene = square();
    const double even = estimate(scene, {}).relaxations;
    scene.stages[1].solver.sweeps = 61; // 3 x 21
    EXPECT_NEAR(estimate(scene, {}).relaxations / even, 63.0 / 60.0, 1e-12);
}

TEST(check, summary_names_what_the_scene_holds) {
    const auto text = describe(square(), {}, 4);
    for (const auto* part :
         {"box of disks", "dimension  2", "floor: 2 points of wall, fixed",
          "piston: 2 points of steel, moves at [0.5, 0] m/s from stage push to 2 s",
          "rock - rock: frictional, friction 0.4", "push: 3 s, 300 steps", "3 substeps, 60 sweeps", "cells      2",
          "a rank on 4", "frames     9",
          "asks for   friction, mixed friction, restitution, grains that may turn, cells, layers, driven walls\n",
          "gauge      slab: 9 bins of 2 m along floor, from 2 to 20 m; every 3 steps, 0.03 s\n",
          "gauge      shove: 1 bin of 20 m along piston, from 0 to 20 m; every 5 steps, 0.05 s\n",
          "probe      one: grain 12345678901; every 7 steps, 0.07 s\n", "probe      two: grain 0; every 5 steps",
          ": mixed friction\n", "State::cells", "(for: friction)", "not carried\n  CandidateSet::bond"}) {
        EXPECT_NE(text.find(part), std::string::npos) << part << " is missing in\n" << text;
    }
}

TEST(check, says_when_smooth_stages_are_settled_and_how_often_stages_of_other_steps_are_looked_at) {
    auto scene = square();
    scene.output.probes[1].grain = -1;
    scene.stages[0].solver.method = SolverSettings::Method::cundall;
    for (auto& law : scene.laws) {
        law.springs = Springs{{1e6, {}}, {1e6, {}}};
    }
    auto slower = scene.stages[1];
    slower.solver.h = 0.02;
    scene.stages.push_back(slower);
    const auto text = describe(scene, {}, 1);
    for (const auto* part : {"until kinetic 1e-07 and unbalanced 0.001, at most 50 s",
                             "probe      two: grain -1 (-1 is the last); every 5 steps, 0.05 s or 0.1 s\n"}) {
        EXPECT_NE(text.find(part), std::string::npos) << part << " is missing in\n" << text;
    }
}

TEST(check, grains_of_a_lattice_are_counted) {
    const auto scene = parse_scene(test::sound_scene, "good.toml",
                                   {"sample.arrangement=square", "sample.radius={ law = \"constant\", value = 0.5 }",
                                    "sample.profile=[[0,0],[20,0],[20,10],[0,10]]", "output.probes.one.grain=7"});
    EXPECT_EQ(estimate(scene, {}).grains, 201);
    const auto text = describe(scene, {}, 1);
    EXPECT_NE(text.find("grains     201\n"), std::string::npos) << text;
}

TEST(check, says_where_a_deposit_has_more_grains_than_by_its_solid_fraction) {
    const auto line = [](const char* radii) {
        const auto text =
            describe(parse_scene(test::sound_scene, "good.toml", {fmt::format("sample.radius={}", radii)}), {}, 1);
        const auto at = text.find("\ngrains     ", text.find("\nestimates"));
        return text.substr(at + 1, text.find('\n', at + 1) - at - 1);
    };
    EXPECT_TRUE(line(R"({ law = "uniform", min = 0.1, max = 0.3 })").ends_with(" (solid fraction 0.83)"));
    const auto many = line(R"({ law = "uniform", min = 0.1, max = 0.5 })");
    EXPECT_TRUE(many.ends_with("(solid fraction 0.83; more, since small ones also fill holes between large ones)"))
        << many;
}

} // namespace
} // namespace nappe
