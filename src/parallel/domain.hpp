#pragma once
// The rank's share of the world: which tiles it owns, which grains it holds. Everything that changes at a rebuild goes
// through here: new tiles, moved tiles, migrating grains with their impulses, ghosts, and the proof that no grain was
// lost.

#include "core/contact_set.hpp"
#include "core/exact_sum.hpp"
#include "core/scene.hpp"
#include "core/state.hpp"
#include "parallel/balance_judge.hpp"
#include "parallel/communicator.hpp"
#include "parallel/halo.hpp"
#include "parallel/large_grains.hpp"
#include "parallel/tile_directory.hpp"
#include "parallel/tile_graph.hpp"

#include <array>
#include <string>
#include <vector>

namespace nappe {

/// What this rank has done since the last look at the balance.
struct SpentTime {
    double relaxing = 0; ///< [s]
    std::int64_t steps = 0;
};

/// Where a grain is. Trivially copyable.
template <int D>
struct PlacedGrain {
    GlobalId id = 0;
    std::array<double, D> x{}; ///< [m]
};

template <int D>
class Domain {
public:
    Domain(const Communicator& comm, const TileGrid<D>& grid, const BalanceSettings& balance)
        : comm_(comm), grid_(grid), balance_(balance), judge_(balance), halo_(comm) {}

    /// **Collective.** Spreads a new set of grains, rows in any order on any ranks, over the ranks by tiles of equal
    /// grain count, or as `owners` says. Ids must be distinct. @param n_wall_bodies rows to keep in State for walls.
    void distribute(std::vector<GrainRecord<D>> grains, std::vector<ContactRow<D>> impulses, LocalId n_wall_bodies,
                    State<D>& state, ContactMemory<D>& memory, const std::vector<TileOwner>& owners = {});

    /// **Collective.** Moves every held grain to its place, without a rebuild. Pre: between the ranks, one place for each
    /// grain.
    void place(const std::vector<PlacedGrain<D>>& places, State<D>& state) const;

    /// **Collective.** At a rebuild: sends owned grains (with their new margins) and the impulses that `memory` has of
    /// them to the owners of the tiles they are in now, puts rows in the order of (tile, id), fetches ghosts (x_ref = x).
    /// Pre: `memory` is by the present rows (ContactMemory::keep or rekey). Throws NumericalFailure if a grain left the
    /// world that tiles can name, SystemError if a grain was lost.
    void rebuild(State<D>& state, LocalId n_wall_bodies, ContactMemory<D>& memory);

    /// **Collective.** To be called before a rebuild; moves tiles if their load is uneven beyond the scene's threshold
    /// and a move pays (BalanceJudge). Returns whether they moved. Grains follow at that rebuild.
    bool balance(const std::vector<TileWork>& work, const std::vector<TileLink>& links, const SpentTime& spent = {});

    /// **Collective.** What the last move and its rebuild cost this rank, over a rebuild without a move [s].
    void moved(double seconds) { judge_.moved(comm_.max(seconds)); }

    /// **Collective.** Who must hear of what, for the candidates found after a rebuild.
    void build_halo(const State<D>& state, CandidateSet<D>& candidates) {
        halo_.build(state, grid_, directory_, range_max_, large_, candidates);
    }

    Halo<D>& halo() { return halo_; }
    const Halo<D>& halo() const { return halo_; }
    const Communicator& comm() const { return comm_; }
    const TileGrid<D>& grid() const { return grid_; }
    const TileDirectory& directory() const { return directory_; }

    /// Largest margin tiles allow: two tiles of one colour must not reach the same grain, so 4 (r + margin + attraction)
    /// < S [m].
    double largest_margin(double r_max, double attraction) const { return 0.2499 * grid_.side() - r_max - attraction; }

    std::int64_t n_grains() const { return n_grains_; }  ///< of all ranks
    double last_imbalance() const { return imbalance_; } ///< largest over mean load, when last looked at

private:
    /// The owned rows in one tile.
    struct Span {
        TileKey key = 0;
        LocalId begin = 0, end = 0;
    };
    /// A grain that is not in the tile it was in, or whose tile is not this rank's any more.
    struct Mover {
        TileKey key = 0; ///< of the tile it is in now
        GlobalId id = 0;
        LocalId row = 0; ///< its own until now; -1 - k: the k-th that arrived
        bool operator<(const Mover& o) const { return key != o.key ? key < o.key : id < o.id; }
    };

    static constexpr TileKey nowhere = ~TileKey{0}; ///< of a position that tiles can not name

    // domain_rebuild.cpp
    static std::string left_the_world(GlobalId id, const Vec<D>& x);
    static double widest_reach(const State<D>& state);
    std::vector<Mover> find_movers(const State<D>& state) const;
    bool settle_tiles(const State<D>& state, const std::vector<Mover>& movers);
    std::vector<GrainRecord<D>> migrate(const State<D>& state, std::vector<Mover>& movers, ContactMemory<D>& memory);
    std::vector<LocalId> merge_rows(const State<D>& state, const std::vector<Mover>& gone, std::vector<Mover> here);
    std::vector<GrainRecord<D>> fetch_ghosts(const State<D>& state);
    void find_holders_of_large(const State<D>& state);
    void sort_by_tile(std::vector<GrainRecord<D>>& grains) const;
    void list_tiles(const State<D>& state);
    void count(const State<D>& state, bool first);

    // domain.cpp
    void own_as(const std::vector<TileOwner>& owners);
    void cut_by_grains(const std::vector<GrainRecord<D>>& grains);
    std::vector<ContactRow<D>> send_after(const std::vector<GrainRecord<D>>& grains,
                                          const std::vector<ContactRow<D>>& impulses) const;

    const Communicator& comm_;
    TileGrid<D> grid_;
    BalanceSettings balance_;
    BalanceJudge judge_;
    Halo<D> halo_;
    LargeGrains<D> large_;
    TileDirectory directory_;
    std::vector<Span> own_tiles_; ///< by key
    double range_max_ = 0;
    double imbalance_ = 1;
    std::int64_t n_grains_ = 0;
    std::uint64_t id_check_ = 0;
    double mass_ = 0;
};

} // namespace nappe
