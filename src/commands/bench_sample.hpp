#pragma once
// The sample of `nappe bench`: a settled block of disks, repeated side by side. Cheap to make at any size, and the same
// contacts per grain at all of them.

#include "core/rows.hpp"
#include "core/scene.hpp"
#include "solver/simulation.hpp"

#include <functional>
#include <vector>

namespace nappe {

/// Index of the scene's stages: how many sweeps a step has.
enum class BenchStage : int { sweeps_100 = 0, sweeps_10 = 1 };

inline constexpr std::int64_t block_grains = 3000; ///< about so many are in a block

/// Disks of jobs/fold.toml settled in a bed 30 m high between smooth walls, inside [0, length].
struct SettledBlock {
    double length = 0; ///< [m]
    std::vector<GrainRow<2>> grains;
    std::vector<ContactRow<2>> impulses;
};

/// A box for so many blocks, with the stages of BenchStage.
Scene<2> bench_scene(double length);

inline constexpr double bench_friction = 0.4;

/// **Local.** Deposits a block and lets it settle for `steps` steps of 100 sweeps; the same bits wherever it is done.
/// @param alone a communicator of this rank only @param grains about how many @param friction of grains and floor
SettledBlock settle_block(const Communicator& alone, std::int64_t grains, int steps, double friction = bench_friction);

/// How many blocks make a sample of about so many grains.
std::int64_t n_copies(const SettledBlock& block, std::int64_t grains);

/// Rows of a sample.
struct BenchSample {
    std::vector<GrainRow<2>> grains;
    std::vector<ContactRow<2>> impulses;
};

/// **Local.** Copies [first, last) of n: ids follow each other, every other copy is the mirror image of the one before.
/// So a grain that leant on a side wall, which was smooth, now leans on its own image with the same force, and the whole
/// is at rest as the block was. (Rejected: copies all alike; what leant on a wall falls into the gaps beyond it.)
/// Impulses come along.
BenchSample repeat_block(const SettledBlock& block, std::int64_t first, std::int64_t last, std::int64_t n);

/// **Collective.** Loads a simulation of bench_scene(n * block.length) with n copies, each rank making its share, and
/// starts the stage; nothing of the rows stays in memory.
void load_copies(Simulation<2>& simulation, const SettledBlock& block, std::int64_t n);

/// **Collective.** What rank 0 does by itself; a NumericalFailure there is one of all ranks.
void on_root_alone(const Communicator& comm, const std::function<void()>& work);

} // namespace nappe
