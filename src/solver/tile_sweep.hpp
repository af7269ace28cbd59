#pragma once
// Passes over all tiles in the order of TileOrder, with the exchange of velocities after each tile colour: colour by
// colour, first the tiles whose grains other ranks hold, then, while messages fly, the rest. In time, several passes go
// over a part of the sample together where that changes nothing. The contacts of large grains come behind each pass, when
// its velocities have arrived. What is done to a tile is the caller's.

#include "core/exact_sum.hpp"
#include "core/stopwatch.hpp"
#include "parallel/domain.hpp"
#include "solver/disk_contacts.hpp"
#include "solver/fused_pass.hpp"
#include "solver/tile_order.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace nappe {

/// The packed contacts of a dimension and shape: disks in the plane.
template <int D>
struct ContactKind;
template <>
struct ContactKind<2> {
    using Contacts = DiskContacts;
};
template <int D>
using ContactsOf = typename ContactKind<D>::Contacts;

/// Hands each tile on when the next one is known.
template <class Visit>
class OneBehind {
public:
    explicit OneBehind(Visit& visit) : visit_(visit) {}

    void push(const std::vector<std::int32_t>& tiles) {
        for (const auto t : tiles) {
            const auto tile = static_cast<std::size_t>(t);
            if (held_ != no_tile) {
                visit_(held_, tile);
            }
            held_ = tile;
        }
    }

    void flush() {
        if (held_ != no_tile) {
            visit_(held_, no_tile);
        }
        held_ = no_tile;
    }

private:
    Visit& visit_;
    std::size_t held_ = no_tile;
};

template <int D>
class TileSweep {
public:
    TileSweep(const Communicator& comm, Stopwatch& watch) : comm_(comm), watch_(watch) {}

    /// Local. After a rebuild: which tiles come first.
    /// @param with_bodies also which bodies the contacts of each tile may move
    void order_tiles(const CandidateSet<D>& candidates, bool with_bodies = false);

    /// Local. Rows of the grains that a tile's contacts may move, ascending; listed by order_tiles if it was asked to. A
    /// function of the frozen lists.
    std::span<const LocalId> bodies(std::size_t tile) const { return bodies_.of(tile); }
    /// Local. Rows of the tiles around a tile, itself included, that this rank owns; listed likewise.
    std::span<const std::int32_t> around(std::size_t tile) const { return around_.of(tile); }
    /// Local. Whether another rank may move some body of the tile; known if bodies were listed.
    bool shared(std::size_t tile) const { return shared_[tile]; }

    /// Local. How many passes over so many bytes should go together.
    int together(double bytes) const {
        // Where ranks wait for each other, layers of one rank are as much work as the other's only near the cut: beyond
        // two sweeps at a time the wait costs more than the cache saves (docs/performance.md).
        const int most = comm_.size() > 1 ? 2 : std::numeric_limits<int>::max();
        return std::min(most, sweeps_in_cache(bytes, order_.last_layer() + 1, n_tile_colours<D>));
    }

    /// **Collective.** n passes over all tiles, so many `together`; visit(t, next) for tile t, `next` the one after it or
    /// no_tile. What it changes in u of grains that others hold is sent to them after each colour.
    /// With Halo::by_sweep passes go one by one, and grains that others hold are exchanged once in each.
    template <class Body, class Visit>
    void run(int n, int together, Halo<D>& halo, std::vector<Body>& u, Visit&& visit);

    /// Local. After order_tiles, if `pass` is to be called: which tiles hold grains that others move before the tile's turn.
    void find_early(const Halo<D>& halo);

    /// **Collective.** One pass that begins and ends a step as well (fused_pass.hpp): open(t), press(t), close(t). Where a
    /// large grain may touch any tile's, all are closed behind it. Pre: find_early.
    template <class Open, class Press, class Close>
    void pass(Halo<D>& halo, std::vector<BodyVelocity<D>>& u, const Open& open, const Press& press,
              const Close& close) {
        const bool alone = comm_.size() == 1;
        const auto close_all = [&] {
            for (std::size_t t = 0; t < grains_.size(); ++t) {
                close(t);
            }
        };
        if (!alone && halo.by_sweep()) {
            for (std::size_t t = 0; t < grains_.size(); ++t) {
                open(t);
            }
            run(1, 1, halo, u, [&](std::size_t t, std::size_t) { press(t); });
            close_all();
            return;
        }
        for (const std::size_t t : early_) {
            open(t);
        }
        const auto open_late = [&](std::size_t t) {
            if (!is_early_[t]) {
                open(t);
            }
        };
        if (large_ == no_tile) {
            fused_pass(order_, alone, watch_, halo, u, open_late, press, close);
            return;
        }
        fused_pass(order_, alone, watch_, halo, u, open_late, press, [](std::size_t) {});
        press(large_);
        close_all();
    }

    /// **Collective.** Sum of term(i) over all grains, i the row on the rank that owns it; the same on any number of ranks.
    template <class Term>
    double sum_over_grains(Term&& term) {
        ExactSum sum;
        for (const auto& [begin, end] : grains_) {
            double of_tile = 0;
            for (LocalId i = begin; i < end; ++i) {
                of_tile += term(i);
            }
            sum.add(of_tile);
        }
        const auto lap = watch_.lap(Timed::exchange);
        comm_.sum(sum.limbs());
        return sum.value();
    }

    /// Local. From now on passes note the seconds that each tile takes, by its row, the last of them; nullptr: no more.
    void time_into(std::vector<double>* seconds) { seconds_ = seconds; }

    const Communicator& comm() const { return comm_; }
    Stopwatch& watch() { return watch_; }

private:
    template <class Body, class Visit>
    void run_untimed(int n, int together, Halo<D>& halo, std::vector<Body>& u, Visit& visit);
    template <class Body, class Visit>
    void run_tiles(int n, int together, Halo<D>& halo, std::vector<Body>& u, Visit& visit);
    template <class Body, class Visit>
    void run_coupled_by_sweep(int n, Halo<D>& halo, std::vector<Body>& u, Visit& visit);

    const Communicator& comm_;
    Stopwatch& watch_;
    TileOrder<D> order_;
    std::vector<std::pair<LocalId, LocalId>> grains_; ///< rows of each tile
    /// A list for each tile.
    struct Lists {
        std::vector<std::int32_t> items;
        std::vector<std::size_t> begin = {0};

        void clear() {
            items.clear();
            begin.assign(1, 0);
        }
        void end_list() { begin.push_back(items.size()); }
        std::span<const std::int32_t> of(std::size_t tile) const {
            return std::span(items).subspan(begin[tile], begin[tile + 1] - begin[tile]);
        }
    };
    void list_bodies(const CandidateSet<D>& candidates);

    Lists bodies_, around_;
    std::vector<bool> shared_;
    std::vector<std::size_t> early_; ///< tiles to be opened before a pass
    std::vector<bool> is_early_;
    std::size_t large_ = no_tile; ///< the contacts of large grains, if this rank has them
    std::vector<double>* seconds_ = nullptr;
};

template <int D>
template <class Body, class Visit>
void TileSweep<D>::run(int n, int together, Halo<D>& halo, std::vector<Body>& u, Visit&& visit) {
    if (seconds_ == nullptr) {
        run_untimed(n, together, halo, u, visit);
        return;
    }
    using Clock = std::chrono::steady_clock;
    auto timed = [&](std::size_t t, std::size_t next) {
        const auto start = Clock::now();
        visit(t, next);
        (*seconds_)[t] = std::chrono::duration<double>(Clock::now() - start).count();
    };
    run_untimed(n, together, halo, u, timed);
}

/// A pass must have ended, on this rank, before the contacts of large grains: several of them can not go together.
template <int D>
template <class Body, class Visit>
void TileSweep<D>::run_untimed(int n, int together, Halo<D>& halo, std::vector<Body>& u, Visit& visit) {
    if (large_ == no_tile) {
        run_tiles(n, together, halo, u, visit);
        return;
    }
    for (int pass = 0; pass < n; ++pass) {
        run_tiles(1, 1, halo, u, visit);
        visit(large_, no_tile);
    }
}

/// Groups of passes. Moments 0 … P - 1 of a group of P phases are those in which layer 0 has a phase to do; in the P + d-th
/// layer d does its last. Where ranks wait for each other, the moments after P - 1 are kept for the next group's messages:
/// its moment m touches layers up to m, whose neighbours the group before must have left.
template <int D>
template <class Body, class Visit>
void TileSweep<D>::run_tiles(int n, int together, Halo<D>& halo, std::vector<Body>& u, Visit& visit) {
    constexpr int n_colours = n_tile_colours<D>;
    const int last = order_.last_layer();
    const bool alone = comm_.size() == 1;
    if (halo.by_sweep() && !alone) {
        run_coupled_by_sweep(n, halo, u, visit);
        return;
    }
    OneBehind tiles(visit);
    const auto inner = [&](int moment, int n_phases) { // layers 1 and up of one moment
        for (int phase = std::max(0, moment - last); phase < std::min(moment, n_phases); ++phase) {
            tiles.push(order_.tiles(moment - phase, phase % n_colours));
        }
    };
    int before = 0, drained = 0; // phases of the group before, and how many of its `last` late moments are done
    const auto drain = [&](int until) {
        for (; before > 0 && drained < std::min(until, last); ++drained) {
            inner(before + drained, before);
        }
    };
    bool arriving = false;
    const auto receive = [&] {
        tiles.flush();
        if (arriving) {
            const auto lap = watch_.lap(Timed::exchange);
            halo.finish(u);
        }
        arriving = false;
    };
    for (int done = 0; done < n; done += together) {
        const int n_phases = std::min(together, n - done) * n_colours;
        for (int moment = 0; moment < n_phases; ++moment) {
            drain(moment + 2);
            inner(moment, n_phases);
            if (!alone) {
                drain((last * (moment + 1) + n_phases - 1) / n_phases); // its share, while messages fly
                receive();
            }
            tiles.push(order_.tiles(0, moment % n_colours));
            if (!alone) {
                tiles.flush();
                const auto lap = watch_.lap(Timed::exchange);
                halo.start(moment % n_colours, u);
                arriving = true;
            }
        }
        drain(last);
        before = n_phases;
        drained = 0;
        if (alone) {
            drain(last);
        }
    }
    drain(last);
    receive();
}

/// Each pass on its own, moments as above: after those in which layer 0 has a phase, what others hold is done with, and
/// the other layers' last phases hide its way.
template <int D>
template <class Body, class Visit>
void TileSweep<D>::run_coupled_by_sweep(int n, Halo<D>& halo, std::vector<Body>& u, Visit& visit) {
    constexpr int n_colours = n_tile_colours<D>;
    OneBehind tiles(visit);
    for (int pass = 0; pass < n; ++pass) {
        {
            const auto lap = watch_.lap(Timed::exchange);
            halo.open_sweep(u);
        }
        for (int moment = 0; moment < n_colours + order_.last_layer(); ++moment) {
            for (int phase = std::max(0, moment - order_.last_layer()); phase <= std::min(moment, n_colours - 1);
                 ++phase) {
                tiles.push(order_.tiles(moment - phase, phase));
            }
            if (moment == n_colours - 1) {
                tiles.flush();
                const auto lap = watch_.lap(Timed::exchange);
                halo.start_sweep(u);
            }
        }
        tiles.flush();
        const auto lap = watch_.lap(Timed::exchange);
        halo.finish_sweep(u);
    }
}

} // namespace nappe
