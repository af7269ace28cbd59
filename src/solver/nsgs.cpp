#include "solver/nsgs.hpp"

#include "core/exact_sum.hpp"

#include <chrono>
#include <cmath>

namespace nappe {

template <int D>
void Nsgs<D>::order_tiles(const CandidateSet<D>& candidates) {
    for (int c = 0; c < n_tile_colours<D>; ++c) {
        interface_[c].clear();
        interior_[c].clear();
    }
    for (std::size_t t = 0; t < candidates.tiles.size(); ++t) {
        const auto& tile = candidates.tiles[t];
        (tile.interface ? interface_ : interior_)[tile.colour].push_back(static_cast<std::int32_t>(t));
    }
}

template <int D>
template <class Relax>
void Nsgs<D>::pass(Halo<D>& halo, std::vector<BodyVelocity<D>>& u, Relax&& relax) {
    for (int colour = 0; colour < n_tile_colours<D>; ++colour) {
        for (const auto t : interface_[colour]) {
            relax(static_cast<std::size_t>(t));
        }
        if (comm_.size() > 1) {
            const auto lap = watch_.lap(Timed::exchange);
            halo.start(colour, u);
        }
        for (const auto t : interior_[colour]) {
            relax(static_cast<std::size_t>(t));
        }
        if (comm_.size() > 1) {
            const auto lap = watch_.lap(Timed::exchange);
            halo.finish(u);
        }
    }
}

template <int D>
void Nsgs<D>::warm_start(const ContactsOf<D>& contacts, Halo<D>& halo, std::vector<BodyVelocity<D>>& u) {
    pass(halo, u, [&](std::size_t t) { contacts.apply(t, u); });
}

template <int D>
SolveReport Nsgs<D>::solve(ContactsOf<D>& contacts, Halo<D>& halo, std::vector<BodyVelocity<D>>& u,
                           const SolverSettings& settings, int sweeps, double scale) {
    const int most = settings.tolerance ? settings.max_sweeps : sweeps;
    const Task task{contacts, halo, u, settings, sweeps, most, scale > 0 ? scale : 1.0};
    SolveReport report;
    bool within = false;
    while (report.sweeps < most && !within) {
        sweep(task, time_tiles_ && report.sweeps == 0);
        ++report.sweeps;
        report.relaxations += contacts.n_active();
        within = settings.tolerance && stops_after(report.sweeps, task);
    }
    if (settings.tolerance && !within) { // no sweep left to hide this one behind
        within = std::sqrt(comm_.max(largest_squared(task))) / task.unit <= *settings.tolerance;
    }
    report.converged = within || !settings.tolerance;
    return report;
}

template <int D>
void Nsgs<D>::sweep(const Task& task, bool timed) {
    if (!timed) {
        pass(task.halo, task.u, [&](std::size_t t) { task.contacts.relax(t, task.u); });
        return;
    }
    using Clock = std::chrono::steady_clock;
    tile_seconds_.resize(task.contacts.n_tiles());
    pass(task.halo, task.u, [&](std::size_t t) {
        const auto start = Clock::now();
        task.contacts.relax(t, task.u);
        tile_seconds_[t] = std::chrono::duration<double>(Clock::now() - start).count();
    });
}

/// Whether sweep k is the last: one check is under way at a time, since the lag is no longer than the time between two.
template <int D>
bool Nsgs<D>::stops_after(int k, const Task& task) {
    const int lag = check_lag(task.settings);
    const auto is_checked = [&](int sweep) {
        return sweep >= task.least && sweep % task.settings.check_every == 0 && sweep + lag <= task.most;
    };
    if (is_checked(k - lag)) {
        const auto lap = watch_.lap(Timed::exchange);
        if (std::sqrt(agreeing_.take()) / task.unit <= *task.settings.tolerance) {
            return true;
        }
    }
    if (is_checked(k)) {
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
