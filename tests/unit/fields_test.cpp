// A scene carries what it asks for and nothing else: the list of fields against a list by hand, and against the arrays
// of running scenes.

#include "solver/fields.hpp"

#include "solver/disk_batch.hpp"
#include "support/serial_run.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <set>

namespace nappe::fields_test {
namespace {

using test::SceneBuilder;

/// Disks at rest in a box, without friction; `add` asks for more.
struct Case {
    const char* name;
    std::function<void(Scene<2>&)> add;
    std::set<std::string> fields; ///< that come with it
};

constexpr double radius = 0.2;

Scene<2> plain() {
    SceneBuilder builder(0);
    builder.material("coating");
    builder.law(0, 1, 0);
    builder.box(3, 2, {RadiusLaw::Kind::constant, radius, radius}).stage(test::solver(0.01, 5));
    return builder.scene();
}

void with_friction(Scene<2>& scene) {
    for (auto& law : scene.laws) {
        law.friction = 0.3;
    }
}

const std::vector<Case>& cases() {
    static const std::vector<Case> all = {
        {"plain", [](auto&) {}, {}},
        {"friction", with_friction, {"State::rotation", "CandidateSet::r_t", "DiskContacts::tangent"}},
        {"mixed_friction",
         [](auto& scene) { scene.laws[1].friction = 0.3; },
         {"State::rotation", "CandidateSet::r_t", "DiskContacts::tangent", "DiskContacts::friction"}},
        {"cohesion",
         [](auto& scene) {
             scene.laws[0].gamma = 10;
             scene.laws[0].d_w = 0.01;
         },
         {"CandidateSet::bond", "DiskContacts::cohesion"}},
        {"restitution", [](auto& scene) { scene.laws[0].restitution = 0.5; }, {}},
        {"spin",
         [](auto& scene) {
             SingleGrain<2> grain;
             grain.radius = radius;
             grain.position = {1, 3};
             grain.spin[0] = 2;
             scene.grains.push_back(grain);
         },
         {"State::rotation"}},
        {"cells",
         [](auto& scene) {
             scene.output.cells.push_back({"c", {1, 1}, 0.5});
         },
         {"State::cells"}},
        {"layers", [](auto& scene) { scene.sample->layer_tops = {1}; }, {"State::layer"}},
        {"layer_of_one_grain",
         [](auto& scene) {
             SingleGrain<2> grain;
             grain.radius = radius;
             grain.position = {1, 3};
             grain.layer = 2;
             scene.grains.push_back(grain);
         },
         {"State::layer"}},
        {"accelerated",
         [](auto& scene) { scene.stages[0].solver.method = SolverSettings::Method::ansgs; },
         {"Iteration::velocities", "DiskContacts::memory[0]"}},
        {"projected",
         [](auto& scene) { scene.stages[0].solver.method = SolverSettings::Method::apgd; },
         {"Iteration::velocities", "DiskContacts::memory[0]"}},
        {"conjugate",
         [](auto& scene) { scene.stages[0].solver.method = SolverSettings::Method::nncg; },
         {"Iteration::velocities", "DiskContacts::memory[0]", "DiskContacts::memory[1]"}},
        {"conjugate_projected",
         [](auto& scene) { scene.stages[0].solver.method = SolverSettings::Method::cpg; },
         {"Iteration::velocities", "DiskContacts::memory[0]", "DiskContacts::memory[1]"}},
        {"kept_geometry",
         [](auto& scene) { scene.stages[0].solver.substeps = scene.stages[0].solver.geometry_every = 2; },
         {"DiskContacts::kept_gaps", "DiskContacts::summed"}},
        {"geometry_of_one_step", [](auto& scene) { scene.stages[0].solver.substeps = 2; }, {}},
        {"position_correction",
         [](auto& scene) { scene.stages[0].solver.position_correction = 0.2; },
         {"DiskContacts::kept_gaps", "DiskContacts::corrections", "Simulation::correction"}},
        {"smooth",
         [](auto& scene) {
             with_friction(scene);
             for (auto& law : scene.laws) {
                 law.springs = Springs{{1e6}, {1e6}};
             }
             scene.stages[0].solver = smooth_settings(1e-4);
         },
         {"State::rotation", "CandidateSet::r_t", "DiskContacts::tangent", "DiskContacts::kept_gaps",
          "DiskContacts::summed", "DiskContacts::springs", "DiskContacts::tangent_after"}},
        {"adaptive", [](auto& scene) { scene.stages[0].solver.adaptive = 1e-3; }, {"Iteration::quiet"}},
        {"single_precision",
         [](auto& scene) { scene.stages[0].solver.precision = SolverSettings::Precision::single; },
         {"Iteration::u_single", "DiskContacts::single"}},
        {"driven_walls",
         [](auto& scene) {
             scene.walls[1].motion = Motion<2>{{0.1, 0}, 0, 0, {}};
         },
         {}},
    };
    return all;
}

Scene<2> scene_of(const Case& c) {
    auto scene = plain();
    c.add(scene);
    return scene;
}

std::set<std::string> carried(const Features& features) {
    std::set<std::string> names;
    for (const auto& field : fields_of(features)) {
        if (field.carried) {
            names.insert(std::string(field.where) + "::" + field.name);
        }
    }
    return names;
}

template <class T>
constexpr std::size_t row_bytes = sizeof(T);
template <>
constexpr std::size_t row_bytes<DiskBatch> = sizeof(DiskBatch) / n_lanes;
template <>
constexpr std::size_t row_bytes<TangentBatch> = sizeof(TangentBatch) / n_lanes;
template <>
constexpr std::size_t row_bytes<FrictionBatch> = sizeof(FrictionBatch) / n_lanes;
template <>
constexpr std::size_t row_bytes<KeptGapBatch> = sizeof(KeptGapBatch) / n_lanes;
template <>
constexpr std::size_t row_bytes<SingleBatch> = sizeof(SingleBatch) / n_lanes;
template <>
constexpr std::size_t row_bytes<SearchBatch> = sizeof(SearchBatch) / n_lanes;
template <>
constexpr std::size_t row_bytes<SpringBatch> = sizeof(SpringBatch) / n_lanes;
template <>
constexpr std::size_t row_bytes<CohesionBatch> = sizeof(CohesionBatch) / n_lanes;

/// Bytes of a row of every array that holds something, by name.
std::map<std::string, std::size_t> held(const Simulation<2>& simulation) {
    std::map<std::string, std::size_t> bytes;
    const auto look = [&](const char* where) {
        return [&bytes, where](const char* name, const auto& array) {
            if (array.capacity() > 0) { // not only used: memory must not be taken either
                bytes[std::string(where) + "::" + name] = row_bytes<typename std::decay_t<decltype(array)>::value_type>;
            }
        };
    };
    simulation.state().for_each_array(look("State"));
    simulation.candidates().for_each_array(look("CandidateSet"));
    simulation.contacts().for_each_array(look("DiskContacts"));
    return bytes;
}

TEST(Fields, EveryFeatureBringsItsOwnAndNoOther) {
    const std::set<std::string> always = {"State::id",
                                          "State::x",
                                          "State::mid",
                                          "State::x_ref",
                                          "State::margin",
                                          "State::u",
                                          "State::u_old",
                                          "State::radius",
                                          "State::mass",
                                          "State::material",
                                          "CandidateSet::a",
                                          "CandidateSet::b",
                                          "CandidateSet::r_n",
                                          "DiskContacts::batches",
                                          "DiskContacts::source",
                                          "DiskContacts::asleep"};
    for (const auto& c : cases()) {
        auto wanted = always;
        wanted.insert(c.fields.begin(), c.fields.end());
        EXPECT_EQ(carried(features_of(scene_of(c))), wanted) << c.name;
    }
}

TEST(Fields, RunningScenesHoldWhatTheListSays) {
    for (const auto& c : cases()) {
        test::SerialRun run(scene_of(c));
        auto& simulation = run.simulation();
        simulation.mark_cells();
        run.steps(20);
        simulation.start_stage(0); // a rebuild
        run.steps(2);
        ASSERT_GT(simulation.contacts().n_active(), 10) << c.name;
        std::map<std::string, std::size_t> listed;
        for (const auto& field : fields_of(features_of(simulation.scene()))) {
            if (field.carried && field.where != std::string("Iteration") && field.where != std::string("Simulation")) {
                listed[std::string(field.where) + "::" + field.name] = field.bytes;
            }
        }
        EXPECT_EQ(held(simulation), listed) << c.name;
    }
}

/// Of every body, grains and walls, what the method and the correction keep; of the bodies of quiet tiles, what each such
/// tile noted, so that is not a number of every body.
TEST(Fields, MethodsHoldWhatTheListSays) {
    for (const auto& c : cases()) {
        test::SerialRun run(scene_of(c));
        auto& simulation = run.simulation();
        run.steps(20);
        const auto bodies = simulation.state().u.size();
        std::size_t method = 0, correction = 0;
        bool quiet = false;
        for (const auto& field : fields_of(features_of(simulation.scene()))) {
            const bool counts = field.carried && field.name != std::string("quiet");
            quiet = quiet || (field.carried && !counts);
            method += counts && field.where == std::string("Iteration") ? field.bytes * bodies : 0;
            correction += counts && field.where == std::string("Simulation") ? field.bytes * bodies : 0;
        }
        EXPECT_EQ(simulation.bytes_of_correction(), correction) << c.name;
        if (quiet) {
            run.steps(400); // to rest
            EXPECT_EQ(simulation.bytes_of_method() % sizeof(BodyVelocity<2>), 0u) << c.name;
            EXPECT_GT(simulation.bytes_of_method(), 0u) << c.name;
        } else {
            EXPECT_EQ(simulation.bytes_of_method(), method) << c.name;
        }
    }
}

/// An array that for_each_array does not name would escape the test above.
TEST(Fields, NoArrayIsLeftOut) {
    constexpr std::size_t vector = sizeof(std::vector<double>);
    std::size_t n = 0;
    State<2>().for_each_array([&](const char*, const auto&) { ++n; });
    struct Others { // of State
        Features carries;
        LocalId n_own;
        double attraction, large_above;
    };
    EXPECT_EQ(sizeof(State<2>), n * vector + sizeof(Others));
    n = 2; // tiles and class_begin are not of candidates
    CandidateSet<2>().for_each_array([&](const char*, const auto&) { ++n; });
    EXPECT_EQ(sizeof(CandidateSet<2>), n * vector + alignof(CandidateSet<2>)); // counts_large
}

TEST(Fields, BytesAreThoseOfTheArrays) {
    Features none;
    none.friction = none.mixed_friction = none.restitution = none.cohesion = none.turning = none.cells = none.layers =
        none.driven_walls = false;
    none.kept_normals = none.kept_gaps = none.correction = none.adaptive = none.single = none.smooth = false;
    none.impulses_kept = none.velocities_kept = 0;
    EXPECT_EQ(bytes_per_grain(none), 8u + 16 + 32 + 16 + 8 + 32 + 32 + 8 + 8 + 4);
    EXPECT_EQ(bytes_per_contact(none), (4u + 4 + 8 + 4) + (6 * 8 + 4));
    EXPECT_EQ(bytes_per_grain(Features()), bytes_per_grain(none) + 8 + 8 + 4 + 2 * 32 + 32 + 32 + 16);
    EXPECT_EQ(bytes_per_contact(Features()), bytes_per_contact(none) + (8 + 1) + 5 * 8 + 3 * 16 + 48 + 32 + 5 * 8);
}

TEST(Fields, VariantsOfTheKernelAreNamed) {
    std::set<std::string> names;
    for (const auto& c : cases()) {
        names.insert(kernel_variant(features_of(scene_of(c))));
    }
    EXPECT_EQ(names,
              (std::set<std::string>{"frictionless", "frictionless, cohesive", "one friction", "mixed friction"}));
}

} // namespace
} // namespace nappe::fields_test
