// The sweep at which a tolerance ends a step: a function of the residuals, not of ranks or of when messages arrive.
#include "core/initial_grains.hpp"
#include "solver/simulation.hpp"
#include "support/kernels.hpp"
#include "support/scene_builder.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace nappe {
namespace {

struct Outcome {
    int sweeps = 0;
    bool converged = false;
    double residual = 0; ///< at the end
    std::uint64_t hash = 0;
};

/// Collective. The first step of a scene, from free fall.
Outcome first_step(const Communicator& comm, const Scene<2>& scene, const char* kernel = nullptr) {
    Simulation<2> simulation(comm, scene, disk_kernels(kernel));
    simulation.load(comm.is_root() ? initial_grains(scene) : std::vector<GrainRow<2>>{}, {}, scene.stages[0].solver.h);
    simulation.start_stage(0);
    simulation.step(0, true);
    return {simulation.last_sweeps(), simulation.counters().unconverged == 0, simulation.last_residual()->largest,
            simulation.state_hash()};
}

SolverSettings with_tolerance(double tolerance, int least, int check_every, int most) {
    auto settings = test::solver(0.01, least);
    settings.tolerance = tolerance;
    settings.check_every = check_every;
    settings.max_sweeps = most;
    return settings;
}

/// Grains enough for tiles on five ranks.
Scene<2> pile(const SolverSettings& settings) {
    auto scene = test::SceneBuilder(0.4).box(24, 6, {RadiusLaw::Kind::uniform, 0.42, 0.56}, 1).stage(settings).scene();
    scene.tiles.side = 3;
    return scene;
}

class Tolerance : public testing::Test {
protected:
    const Communicator world;
};

TEST_F(Tolerance, EndsAtTheFirstCheckThatPassesPlusTheLag) {
    constexpr int most = 48;
    std::vector<double> residual(most + 1);
    for (int k = 1; k <= most; ++k) {
        residual[static_cast<std::size_t>(k)] = first_step(world, pile(test::solver(0.01, k))).residual;
    }
    const auto after = [&](int k) { return residual[static_cast<std::size_t>(k)]; };
    ASSERT_LT(after(40), 0.9 * after(12)) << "the case is too easy: nothing converges";
    int early = 0, late = 0, never = 0;
    for (const double tolerance : {after(12), after(40), after(most), 1e-12}) {
        for (const int check_every : {1, 3, 4, 10}) {
            for (const int least : {1, 9}) {
                const int lag = std::min(4, check_every);
                int wanted = most;
                for (int k = 1; k + lag <= most; ++k) {
                    if (k >= least && k % check_every == 0 && after(k) <= tolerance) {
                        wanted = k + lag;
                        break;
                    }
                }
                const auto found = first_step(world, pile(with_tolerance(tolerance, least, check_every, most)));
                EXPECT_EQ(found.sweeps, wanted) << tolerance << ", every " << check_every << ", least " << least;
                EXPECT_EQ(found.converged, wanted < most || after(most) <= tolerance);
                EXPECT_EQ(found.residual, after(wanted)) << "not the state after as many sweeps";
                (wanted == most ? (found.converged ? late : never) : early) += 1;
            }
        }
    }
    EXPECT_TRUE(early > 0 && late > 0 && never > 0) << early << ", " << late << ", " << never << ": too easy";
}

TEST_F(Tolerance, OneRankAndAllAgreeBitForBit) {
    const Communicator alone(MPI_COMM_SELF);
    for (const int check_every : {1, 5}) {
        const auto scene = pile(with_tolerance(0.05, 2, check_every, 200));
        const auto one = first_step(alone, scene);
        for (const char* kernel : test::kernels_here()) {
            const auto all = first_step(world, scene, kernel);
            EXPECT_EQ(all.sweeps, one.sweeps) << kernel;
            EXPECT_EQ(all.hash, one.hash) << kernel;
        }
    }
}

/// A grain on a floor is solved by its first sweep: its residual is round-off from then on, and the first check passes. So the
/// step ends check_lag after the first multiple of check_every that is not below the least.
TEST_F(Tolerance, OneGrainOnAFloorByFormula) {
    for (const int check_every : {1, 2, 3, 4, 5, 10}) {
        for (const int least : {1, 7, 10}) {
            const auto scene = test::SceneBuilder(0.4)
                                   .floor()
                                   .grain(0.5, {0, 0.5})
                                   .stage(with_tolerance(1e-9, least, check_every, 100))
                                   .scene();
            const auto found = first_step(world, scene);
            const int first_check = (least + check_every - 1) / check_every * check_every;
            EXPECT_EQ(found.sweeps, first_check + std::min(4, check_every)) << check_every << ", " << least;
            EXPECT_TRUE(found.converged);
        }
    }
}

TEST_F(Tolerance, NoCheckFitsBelowTheMost) {
    // Checks at 10, 20, … act at 14, 24, …: with 13 sweeps at most, the only look is after the last.
    const auto within = first_step(world, pile(with_tolerance(1e9, 1, 10, 13)));
    EXPECT_EQ(within.sweeps, 13);
    EXPECT_TRUE(within.converged);
    const auto beyond = first_step(world, pile(with_tolerance(1e-12, 1, 10, 13)));
    EXPECT_EQ(beyond.sweeps, 13);
    EXPECT_FALSE(beyond.converged);
    EXPECT_EQ(first_step(world, pile(with_tolerance(1e9, 1, 10, 14))).sweeps, 14);
    EXPECT_EQ(first_step(world, pile(with_tolerance(1e9, 1, 10, 15))).sweeps, 14);
}

} // namespace
} // namespace nappe
