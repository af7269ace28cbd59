#pragma once
// A scene on all ranks of a communicator, stepped by a test until the watch, or anything else, ends it.

#include "core/error.hpp"
#include "core/initial_grains.hpp"
#include "solver/observables.hpp"
#include "solver/simulation.hpp"
#include "support/scene_builder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

namespace nappe::test {

/// Collective. A scene on all ranks of a communicator, from its own grains or from others.
class WatchedRun {
public:
    explicit WatchedRun(const Communicator& comm, const Scene<2>& scene)
        : WatchedRun(comm, scene, initial_grains(scene), {}) {}
    WatchedRun(const Communicator& comm, const Scene<2>& scene, const std::vector<GrainRow<2>>& grains,
               const std::vector<ContactRow<2>>& impulses)
        : comm_(comm), simulation_(comm, scene, disk_kernels(nullptr)) {
        const auto& s = scene.stages[0].solver;
        simulation_.load(comm.is_root() ? grains : std::vector<GrainRow<2>>{},
                         comm.is_root() ? impulses : std::vector<ContactRow<2>>{}, s.h / s.substeps);
        simulation_.start_stage(0);
    }

    Simulation<2>& simulation() { return simulation_; }
    const WatchMemory& memory() { return simulation_.watcher().memory(); }
    std::int64_t found(Watched what) { return memory().steps[static_cast<std::size_t>(what)]; }

    /// Until a step fails: its text, "" if n steps do not.
    std::string steps(
        std::int64_t n, const std::function<void()>& after = [] {}) {
        for (std::int64_t k = 0; k < n; ++k) {
            try {
                simulation_.step();
            } catch (const NumericalFailure& e) {
                return e.what();
            }
            for (auto& line : simulation_.watcher().take_lines()) {
                lines.push_back(line);
            }
            after();
        }
        return "";
    }

    /// Of all ranks, in the order of ids.
    std::vector<GrainRow<2>> grains() {
        auto rows = comm_.all_gather(simulation_.grain_rows());
        std::sort(rows.begin(), rows.end(), [](const auto& p, const auto& q) { return p.id < q.id; });
        return rows;
    }

    std::vector<std::string> lines;

private:
    const Communicator& comm_;
    Simulation<2> simulation_;
};

inline void expect_same_places(const std::vector<GrainRow<2>>& found, const std::vector<GrainRow<2>>& wanted) {
    ASSERT_EQ(found.size(), wanted.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].id, wanted[i].id);
        EXPECT_EQ(found[i].x, wanted[i].x) << i;
        EXPECT_EQ(found[i].v, wanted[i].v) << i;
        EXPECT_EQ(found[i].spin, wanted[i].spin) << i;
        EXPECT_EQ(found[i].rotation, wanted[i].rotation) << i;
    }
}

#define EXPECT_SAYS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

/// All ranks together, and each by itself, for tests that compare the two.
class WatchTest : public testing::Test {
protected:
    const Communicator world;
    const Communicator alone = Communicator::alone();
};

/// Walls close on a row: overlaps grow until they pass the limit in one step and not in the one before, which observables
/// measure between steps.
inline Scene<2> squeezed(int substeps, int geometry_every, double spacing = 1, double correction = 0) {
    SceneBuilder b(0.4);
    b.gravity(0, 0);
    Motion<2> inwards;
    inwards.stage = 0;
    inwards.velocity = {1.5, 0};
    b.moving_wall("left", {{0, 3}, {0, -3}}, inwards);
    inwards.velocity = {-1.5, 0};
    b.moving_wall("right", {{1.1 + 28 * spacing, -3}, {1.1 + 28 * spacing, 3}}, inwards);
    for (int k = 0; k < 29; ++k) {
        b.grain(0.5, {0.55 + spacing * k, 0});
    }
    for (int k = 0; k < 110; ++k) { // in every quarter of a step one goes into another tile
        b.grain(0.5, {-700 + (2 * 2.7 + 0.025) * k, 8}, {10, 0});
    }
    auto settings = solver(0.01, 4 * substeps);
    settings.substeps = substeps;
    settings.geometry_every = geometry_every;
    settings.position_correction = correction;
    b.stage(settings);
    auto scene = b.scene();
    scene.tiles.side = 2.7;
    scene.tiles.skin = 0.02; // rebuilds at every other moment, within steps too
    scene.tiles.lookahead = 0.5;
    return scene;
}

} // namespace nappe::test
