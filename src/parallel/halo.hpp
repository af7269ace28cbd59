#pragma once
// Keeps the copies of a grain equal. Words, from the point of view of the rank that reads: a *holder* of a grain is a
// rank that has a row for it — its owner, and every rank one of whose tiles lies within reach of the grain. After each
// tile colour a rank *sends* the velocities that its tiles of that colour changed to the grains' other holders, and
// *receives* the like. In one colour a grain is changed by at most one tile, so every row has at most one sender and
// copies are equal after each colour.

#include "core/contact_set.hpp"
#include "core/state.hpp"
#include "parallel/communicator.hpp"
#include "parallel/tile_directory.hpp"

#include <array>
#include <vector>

namespace nappe {

/// The other ranks that hold a grain; a function of positions at the last rebuild and of tile ownership.
template <int D>
class Holders {
public:
    Holders(const TileGrid<D>& grid, const TileDirectory& directory, int rank)
        : grid_(grid), directory_(directory), rank_(rank) {}

    /// Local. @param tile of the grain @param x_ref its position [m] @param range radius + margin of the grain plus the
    /// largest radius + margin of all grains [m]. Fills `ranks` in ascending order, without this rank.
    void find(TileKey tile, const Vec<D>& x_ref, double range, std::vector<int>& ranks);

private:
    const TileGrid<D>& grid_;
    const TileDirectory& directory_;
    int rank_;
    // The ring of the tile asked last: grains come sorted by tile.
    TileKey last_ = 0;
    bool any_ = false;
    bool known_ = false;
    std::array<TileKey, TileGrid<D>::n_ring> ring_{};
    std::array<std::int32_t, TileGrid<D>::n_ring> owner_{};
};

/// Counters of what the exchange moved, for summary and scaling tests.
struct HaloTraffic {
    std::int64_t messages_sent = 0;
    std::int64_t bytes_sent = 0;
};

template <int D>
class Halo {
public:
    explicit Halo(const Communicator& comm) : comm_(comm) {}

    /// **Collective.** From the candidates of owned tiles, who has to hear of what after which colour; marks interface
    /// tiles.
    /// @param range_max largest radius + margin of all grains [m].
    void build(const State<D>& state, const TileGrid<D>& grid, const TileDirectory& directory, double range_max,
               CandidateSet<D>& candidates);

    /// Starts to send what the interface tiles of `colour` have changed, and to receive. Local (non-blocking).
    void start(int colour, const std::vector<BodyVelocity<D>>& u);

    /// Waits for it and writes what came into u.
    void finish(std::vector<BodyVelocity<D>>& u);

    const HaloTraffic& traffic() const { return traffic_; }

    /// Bytes and messages that one sweep sends from this rank.
    HaloTraffic per_sweep() const;

private:
    static constexpr int n_values = D + n_spin<D>;

    struct Link { ///< with one other rank, for one colour
        int rank = 0;
        std::vector<LocalId> rows; ///< by GlobalId
        std::vector<double> buffer;
    };

    const Communicator& comm_;
    std::array<std::vector<Link>, n_tile_colours<D>> sends_, receives_;
    std::vector<MPI_Request> requests_;
    std::vector<Link>* arriving_ = nullptr;
    HaloTraffic traffic_;
};

} // namespace nappe
