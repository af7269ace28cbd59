#pragma once
// All that the next step depends on, between two steps: what a checkpoint holds. Candidates, tile membership and halo lists
// are not in it: they follow from where everything stood at the last rebuild, which is. Nor are batches, gaps or bonds:
// they follow from positions.

#include "core/rows.hpp"
#include "core/tile_grid.hpp"
#include "core/types.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace nappe {

/// A grain, bit for bit. Trivially copyable.
template <int D>
struct SnapshotGrain {
    GlobalId id = 0;
    std::array<double, D> x{};                ///< [m]
    std::array<double, D> x_ref{};            ///< at the last rebuild [m]
    std::array<double, D> v{};                ///< [m/s]
    std::array<double, n_spin<D>> s{};        ///< radius x spin: the spin itself would be rounded [m/s]
    std::array<double, n_spin<D>> rotation{}; ///< [rad]
    double radius = 0;                        ///< [m]
    double mass = 0;                          ///< [kg]
    double margin = 0;                        ///< since the last rebuild [m]
    std::uint64_t cells = 0;
    std::int32_t material = 0;
    std::int32_t layer = 0;
};

/// A wall. Trivially copyable.
template <int D>
struct SnapshotWall {
    std::array<double, D> offset{};     ///< displacement [m]
    std::array<double, D> offset_ref{}; ///< at the last rebuild [m]
    std::array<double, D> v{};          ///< of the last step [m/s]
    std::array<double, D> v_old{};      ///< that the next step starts from [m/s]
    double margin = 0;                  ///< since the last rebuild [m]
};

/// Who computes a tile: only where results depend on it (SolverSettings::coupling).
struct TileOwner {
    TileKey key = 0;
    std::int64_t rank = 0;
};

/// Clocks, counters and what else a simulation remembers from step to step. The same on all ranks.
struct SnapshotClock {
    std::int64_t stage = 0;
    std::int64_t stage_steps = 0;
    std::int64_t stage_substeps = 0;
    std::int64_t rebuild_due = 0; ///< 0 or 1
    std::int64_t some_fast = 0;   ///< 0 or 1
    std::int64_t energy_wanted = 0;
    std::int64_t summed_steps = 0; ///< in ContactSums, since the last row of the series
    std::int64_t last_balance = 0;
    // Counters of the simulation, but for relaxations, which are each rank's own.
    std::int64_t steps = 0, sweeps = 0, rebuilds = 0, redone_lists = 0, redone_groups = 0, redone_packs = 0,
                 reductions = 0, unconverged = 0, rebalanced = 0;
    // What the watch has found so far (solver/watcher.hpp).
    std::array<std::int64_t, 4> watched{};
    std::int64_t unconverged_in_row = 0, divided_steps = 0, most_substeps = 0;
    double largest_growth = 0, largest_scale = 0;
    double stage_start = 0;     ///< [s]
    double impulse_h = 0;       ///< step whose impulses these are [s]
    double correction_work = 0; ///< [J]

    /// Calls f(name, number) for every field: the one list that storing and loading go by.
    template <class F>
    void for_each(F&& f) {
        f("stage", stage);
        f("stage_steps", stage_steps);
        f("stage_substeps", stage_substeps);
        f("rebuild_due", rebuild_due);
        f("some_fast", some_fast);
        f("energy_wanted", energy_wanted);
        f("summed_steps", summed_steps);
        f("last_balance", last_balance);
        f("steps", steps);
        f("sweeps", sweeps);
        f("rebuilds", rebuilds);
        f("redone_lists", redone_lists);
        f("redone_groups", redone_groups);
        f("redone_packs", redone_packs);
        f("reductions", reductions);
        f("unconverged", unconverged);
        f("rebalanced", rebalanced);
        f("watched_overlap", watched[0]);
        f("watched_energy", watched[1]);
        f("watched_residual", watched[2]);
        f("watched_bounds", watched[3]);
        f("unconverged_in_row", unconverged_in_row);
        f("divided_steps", divided_steps);
        f("most_substeps", most_substeps);
        f("largest_growth", largest_growth);
        f("largest_scale", largest_scale);
        f("stage_start", stage_start);
        f("impulse_h", impulse_h);
        f("correction_work", correction_work);
    }
};

template <int D>
struct Snapshot {
    SnapshotClock clock;
    std::vector<SnapshotGrain<D>> grains; ///< this rank's, in any order
    std::vector<ContactRow<D>> impulses;  ///< likewise, those that are not zero
    std::vector<SnapshotWall<D>> walls;   ///< the same on all ranks, in the order of Scene::walls
    std::vector<std::int64_t> sums;       ///< limbs of ContactSums and EnergySums over all ranks; the same on all
    std::vector<TileOwner> owners;        ///< the same on all ranks, by key; empty where results do not depend on it
};

} // namespace nappe
