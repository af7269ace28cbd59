#pragma once
// Keeps the copies of a grain equal. Words, from the point of view of the rank that reads: a *holder* of a grain is a
// rank that has a row for it — its owner, and every rank one of whose tiles lies within reach of the grain. After each
// tile colour a rank *sends* the velocities that its tiles of that colour changed to the grains' other holders, and
// *receives* the like. In one colour a grain is changed by at most one tile, so every row has at most one sender and
// copies are equal after each colour. A *neighbour* is another holder of some grain held here; the relation is mutual.
//
// Coupled once a sweep (SolverSettings::coupling), a rank sends what its tiles of all colours have made of the grains they
// share, in one message to each neighbour, and every holder adds up the changes in ascending order of ranks:
//     u = u_0 + sum over ranks of (u_rank - u_0),   u_0 from the start of the sweep.
// Copies are equal after each sweep, and M⁻¹ H r is not lost; but which contacts see each other's changes within a sweep
// depends on who owns them.

#include "core/contact_set.hpp"
#include "core/state.hpp"
#include "parallel/communicator.hpp"
#include "parallel/large_grains.hpp"
#include "parallel/tile_directory.hpp"

#include <array>
#include <span>
#include <vector>

namespace nappe {

/// The other ranks that hold a grain; a function of positions at the last rebuild and of tile ownership.
template <int D>
class Holders {
public:
    Holders(const TileGrid<D>& grid, const TileDirectory& directory, int rank)
        : grid_(grid), directory_(directory), rank_(rank) {}
    Holders(const TileGrid<D>& grid, const TileDirectory& directory, int rank, const LargeGrains<D>& large)
        : grid_(grid), directory_(directory), rank_(rank), large_(&large) {}

    /// Local. Whether another rank owns this tile or one around it: if not, nobody else holds the grains in it.
    bool any_near(TileKey tile);

    /// Local. The same, with the ranks that hold the grain since a large one may touch it, or since it is large.
    /// @param i row of the grain, which is in `tile` at x_ref @param range_max largest reach of all grains [m]
    void find_all(TileKey tile, const Vec<D>& x_ref, const State<D>& state, LocalId i, double range_max,
                  std::vector<int>& ranks);

    /// Local. @param tile of the grain @param x_ref its position [m] @param range reach of the grain plus the largest of all
    /// grains [m]. Fills `ranks` in ascending order, without this rank.
    void find(TileKey tile, const Vec<D>& x_ref, double range, std::vector<int>& ranks);

private:
    const TileGrid<D>& grid_;
    const TileDirectory& directory_;
    int rank_;
    const LargeGrains<D>* large_ = nullptr;
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
    ~Halo() { release(); }
    Halo(const Halo&) = delete;
    Halo& operator=(const Halo&) = delete;

    /// **Collective.** From the candidates of owned tiles, who has to hear of what after which colour; marks interface
    /// tiles. Talks to neighbours only. Pre: no pass is under way.
    /// @param range_max largest reach of all grains, large ones left out [m].
    void build(const State<D>& state, const TileGrid<D>& grid, const TileDirectory& directory, double range_max,
               const LargeGrains<D>& large, CandidateSet<D>& candidates);

    /// Local. From the next `build` on: one exchange a sweep, or one a colour.
    void couple_by_sweep(bool by_sweep) { next_by_sweep_ = by_sweep; }
    bool by_sweep() const { return by_sweep_; }

    /// Starts to send what the interface tiles of `colour` have changed, and to receive. Local (non-blocking). A pass
    /// is start and finish of every colour in ascending order; receives of all colours are posted as it begins, so that
    /// a message never waits for its receiver to ask. Real: double or float; messages are in double.
    template <class Real>
    void start(int colour, const std::vector<BodyVelocity<D, Real>>& u);

    /// Waits for what others send after the colour started last, and writes it into u.
    template <class Real>
    void finish(std::vector<BodyVelocity<D, Real>>& u);

    /// Local. Coupled once a sweep: what shared grains start it with.
    template <class Real>
    void open_sweep(const std::vector<BodyVelocity<D, Real>>& u);

    /// The like of `start` when all interface tiles are done with the sweep. Pre: open_sweep.
    template <class Real>
    void start_sweep(const std::vector<BodyVelocity<D, Real>>& u) {
        start(0, u);
    }

    /// Waits for the neighbours' changes and adds them, in the order of ranks.
    template <class Real>
    void finish_sweep(std::vector<BodyVelocity<D, Real>>& u);

    /// Local. Rows that others' tiles change, of own grains and of copies; some more than once.
    std::span<const LocalId> received_rows() const { return receives_.rows; }

    const HaloTraffic& traffic() const { return traffic_; }
    void clear_traffic() { traffic_ = {}; } ///< Local.

    /// Bytes and messages that one sweep sends from this rank.
    HaloTraffic per_sweep() const;

private:
    static constexpr int n_colours = n_tile_colours<D>;
    static constexpr int n_values = D + n_spin<D>; // of a grain, the leading doubles of BodyVelocity
    using ColourBits = std::uint8_t;               // bit c: touched by a tile of colour c
    static_assert(n_colours <= 8);

    /// A grain that others hold too, in an order that all its holders agree on.
    struct Shared {
        TileKey tile;
        GlobalId id;
        LocalId row;
        std::int32_t ranks_begin, ranks_end; ///< into holder_
    };
    /// Another holder, and the grains held by both.
    struct Neighbour {
        int rank;
        std::vector<std::int32_t> common; ///< into shared_
        std::vector<std::byte> out, in;   ///< what each tells the other: a check of the ids, ColourBits of each grain
    };
    /// All that goes one way: rows by (colour, neighbour, shared grain), their values in one buffer, a request for each
    /// message. Messages of colour c are [first[c], first[c + 1]), their rows [row_begin[m], row_begin[m + 1]).
    struct Way {
        std::vector<LocalId> rows;
        std::vector<double> values;
        std::vector<std::int32_t> row_begin;
        std::vector<int> rank;
        std::vector<MPI_Request> requests;
        std::array<std::size_t, n_colours + 1> first{};

        void clear() { // keeps its memory for the next rebuild
            rows.clear();
            values.clear();
            row_begin.clear();
            rank.clear();
            requests.clear();
            first.fill(0);
        }

        std::span<MPI_Request> requests_of(int colour) {
            const auto c = static_cast<std::size_t>(colour);
            return std::span(requests).subspan(first[c], first[c + 1] - first[c]);
        }
        std::span<const LocalId> rows_of(int colour) const {
            const auto c = static_cast<std::size_t>(colour);
            return std::span(rows).subspan(static_cast<std::size_t>(row_begin[first[c]]),
                                           static_cast<std::size_t>(row_begin[first[c + 1]] - row_begin[first[c]]));
        }
        double* values_of(int colour) {
            return values.data() + n_values * row_begin[first[static_cast<std::size_t>(colour)]];
        }
    };

    void release();
    void find_shared(const State<D>& state, const TileGrid<D>& grid, const TileDirectory& directory, double range_max,
                     const LargeGrains<D>& large, const CandidateSet<D>& candidates);
    void find_neighbours();
    void mark_touched(LocalId n_held, CandidateSet<D>& candidates);
    void tell_neighbours();
    void lay_out(Way& way, std::vector<std::byte> Neighbour::*told) const;
    void make_requests();
    template <class Real>
    void add_own_change(std::vector<BodyVelocity<D, Real>>& u) const;

    const Communicator& comm_;
    std::vector<Shared> shared_;              ///< by (tile, id)
    std::vector<int> holder_;                 ///< other ranks of each shared grain
    std::vector<Neighbour> near_;             ///< by rank
    std::vector<ColourBits> touched_;         ///< by own tiles, for each shared grain
    std::vector<std::int32_t> shared_of_row_; ///< -1: nobody else holds it
    Way sends_, receives_;
    int colour_ = 0; ///< started last
    bool by_sweep_ = false, next_by_sweep_ = false;
    std::vector<double> opened_,
        own_; ///< coupled once a sweep, of each shared grain: u_0, and what own tiles made of it
    HaloTraffic traffic_;
};

} // namespace nappe
