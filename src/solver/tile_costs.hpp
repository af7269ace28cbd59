#pragma once
// What each tile of this rank cost since the last look at the balance, counted or measured. Decides who computes what,
// never a bit of the result.

#include "parallel/domain.hpp"
#include "solver/tile_sweep.hpp"

#include <limits>
#include <vector>

namespace nappe {

/// All members are Local.
template <int D>
class TileCosts {
public:
    /// After a rebuild: the tiles are those of `candidates` now; those that stayed keep their costs.
    void relist(const CandidateSet<D>& candidates);

    /// After a solve. @param tile_seconds one sample a tile (ContactSolver::tile_seconds), or none
    /// @param tile_sweeps how often each tile was relaxed; empty: `sweeps` times
    void add(const ContactsOf<D>& contacts, int sweeps, const std::vector<std::int32_t>& tile_sweeps,
             const std::vector<double>& tile_seconds);

    /// Relaxations of each tile.
    std::vector<TileWork> by_work() const;

    /// Nanoseconds: what this rank spent relaxing [s], shared among its tiles by their relaxations times the quickest
    /// sample of a relaxation there. The total shows a slow core or node, the samples tiles that cost more than others;
    /// the quickest, since a sample that was interrupted says nothing of its tile.
    std::vector<TileWork> by_time(double seconds) const;

    void clear();

private:
    struct Cost {
        TileKey key = 0;
        std::int64_t relaxations = 0;
        double quickest = std::numeric_limits<double>::infinity(); ///< of a relaxation [s]
    };
    std::vector<Cost> costs_; ///< by key, rows as in CandidateSet::tiles
};

} // namespace nappe
