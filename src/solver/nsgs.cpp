#include "solver/nsgs.hpp"

#include "core/exact_sum.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace nappe {

namespace {

/// Hands each tile on when the next one is known.
template <class Relax>
class OneBehind {
public:
    explicit OneBehind(Relax& relax) : relax_(relax) {}

    void push(const std::vector<std::int32_t>& tiles) {
        for (const auto t : tiles) {
            const auto tile = static_cast<std::size_t>(t);
            if (held_ != no_tile) {
                relax_(held_, tile);
            }
            held_ = tile;
        }
    }

    void flush() {
        if (held_ != no_tile) {
            relax_(held_, no_tile);
        }
        held_ = no_tile;
    }

private:
    Relax& relax_;
    std::size_t held_ = no_tile;
};

} // namespace

template <int D>
void Nsgs<D>::order_tiles(const CandidateSet<D>& candidates) {
    order_.build(candidates);
}

/// Groups of sweeps. Moments 0 … P - 1 of a group of P phases are those in which layer 0 has a phase to do; in the P + d-th
/// layer d does its last. Where ranks wait for each other, the moments after P - 1 are kept for the next group's messages:
/// its moment m touches layers up to m, whose neighbours the group before must have left.
template <int D>
template <class Relax>
void Nsgs<D>::run(int n, int together, Halo<D>& halo, std::vector<BodyVelocity<D>>& u, Relax&& relax) {
    constexpr int n_colours = n_tile_colours<D>;
    const int last = order_.last_layer();
    const bool alone = comm_.size() == 1;
    OneBehind tiles(relax);
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

template <int D>
void Nsgs<D>::warm_start(ContactsOf<D>& contacts, Halo<D>& halo, std::vector<BodyVelocity<D>>& u) {
    run(1, 1, halo, u, [&](std::size_t t, std::size_t) { contacts.apply(t, u); });
}

template <int D>
SolveReport Nsgs<D>::solve(ContactsOf<D>& contacts, Halo<D>& halo, std::vector<BodyVelocity<D>>& u,
                           const SolverSettings& settings, int sweeps, double scale) {
    const int most = settings.tolerance ? settings.max_sweeps : sweeps;
    const Task task{contacts, halo, u, settings, sweeps, most, scale > 0 ? scale : 1.0};
    const double bytes = static_cast<double>(contacts.bytes_swept() + u.size() * sizeof(BodyVelocity<D>));
    // Where ranks wait for each other, layers of one rank are as much work as the other's only near the cut: beyond two
    // sweeps at a time the wait costs more than the cache saves (docs/performance.md).
    const int most_together = comm_.size() > 1 ? 2 : std::numeric_limits<int>::max();
    const int together = std::min(most_together, sweeps_in_cache(bytes, order_.last_layer() + 1, n_tile_colours<D>));
    SolveReport report;
    bool within = false;
    while (report.sweeps < most && !within) {
        const bool timed = time_tiles_ && report.sweeps == 0;
        const int n = timed ? 1 : next_halt(report.sweeps, task) - report.sweeps;
        sweep(task, n, together, timed);
        report.sweeps += n;
        report.relaxations += n * contacts.n_active();
        within = settings.tolerance && stops_after(report.sweeps, task);
    }
    if (settings.tolerance && !within) { // no sweep left to hide this one behind
        within = std::sqrt(comm_.max(largest_squared(task))) / task.unit <= *settings.tolerance;
    }
    report.converged = within || !settings.tolerance;
    return report;
}

template <int D>
void Nsgs<D>::sweep(const Task& task, int n, int together, bool timed) {
    if (!timed) {
        run(n, together, task.halo, task.u,
            [&](std::size_t t, std::size_t next) { task.contacts.relax(t, next, task.u); });
        return;
    }
    using Clock = std::chrono::steady_clock;
    tile_seconds_.resize(task.contacts.n_tiles());
    run(n, together, task.halo, task.u, [&](std::size_t t, std::size_t next) {
        const auto start = Clock::now();
        task.contacts.relax(t, next, task.u);
        tile_seconds_[t] = std::chrono::duration<double>(Clock::now() - start).count();
    });
}

template <int D>
bool Nsgs<D>::is_checked(int sweep, const Task& task) {
    return sweep >= task.least && sweep % task.settings.check_every == 0 &&
           sweep + check_lag(task.settings) <= task.most;
}

/// The first sweep after k at which something is to be measured or decided.
template <int D>
int Nsgs<D>::next_halt(int k, const Task& task) {
    if (!task.settings.tolerance) {
        return task.most;
    }
    do {
        ++k;
    } while (k < task.most && !is_checked(k, task) && !is_checked(k - check_lag(task.settings), task));
    return k;
}

/// Whether sweep k is the last: one check is under way at a time, since the lag is no longer than the time between two.
template <int D>
bool Nsgs<D>::stops_after(int k, const Task& task) {
    if (is_checked(k - check_lag(task.settings), task)) {
        const auto lap = watch_.lap(Timed::exchange);
        if (std::sqrt(agreeing_.take()) / task.unit <= *task.settings.tolerance) {
            return true;
        }
    }
    if (is_checked(k, task)) {
        agreeing_.start(comm_, largest_squared(task));
    }
    return false;
}

template <int D>
double Nsgs<D>::largest_squared(const Task& task) {
    const auto lap = watch_.lap(Timed::residual);
    double largest = 0;
    for (std::size_t t = 0; t < task.contacts.n_tiles(); ++t) {
        const double of_tile = task.contacts.residual(t, task.u).largest_squared;
        largest = of_tile > largest ? of_tile : largest;
    }
    return largest;
}

template <int D>
Residual Nsgs<D>::residual(const ContactsOf<D>& contacts, const std::vector<BodyVelocity<D>>& u, double scale) {
    const auto lap = watch_.lap(Timed::residual);
    double largest = 0;
    ExactSum squares;
    std::int64_t n = 0;
    for (std::size_t t = 0; t < contacts.n_tiles(); ++t) {
        const auto of_tile = contacts.residual(t, u);
        largest = of_tile.largest_squared > largest ? of_tile.largest_squared : largest;
        squares.add(of_tile.sum_squared);
        n += of_tile.contacts;
    }
    largest = comm_.max(largest);
    comm_.sum(squares.limbs());
    n = comm_.sum(n);
    const double unit = scale > 0 ? scale : 1.0;
    return {std::sqrt(largest) / unit, n > 0 ? std::sqrt(squares.value() / static_cast<double>(n)) / unit : 0.0};
}

template class Nsgs<2>;

} // namespace nappe
