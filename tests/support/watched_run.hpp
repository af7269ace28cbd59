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

} // namespace nappe::test
