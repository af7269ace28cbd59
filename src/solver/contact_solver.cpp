#include "solver/contact_solver.hpp"

#include "core/exact_sum.hpp"

#include <cmath>

namespace nappe {

template <int D>
void ContactSolver<D>::warm_start(ContactsOf<D>& contacts, Halo<D>& halo, std::vector<BodyVelocity<D>>& u) {
    sweep_.run(1, 1, halo, u, [&](std::size_t t, std::size_t) { contacts.apply(t, u); });
}

template <int D>
void ContactSolver<D>::correct(ContactsOf<D>& contacts, Halo<D>& halo, std::vector<BodyVelocity<D>>& w, int n) {
    sweep_.run(n, 1, halo, w, [&](std::size_t t, std::size_t next) { contacts.relax_correction(t, next, w); });
}

template <int D>
SolveReport ContactSolver<D>::solve(ContactsOf<D>& contacts, Halo<D>& halo, std::vector<BodyVelocity<D>>& u,
                                    const SolverSettings& settings, int sweeps, double scale) {
    const int most = settings.tolerance ? settings.max_sweeps : sweeps;
    const Task task{{contacts, halo, u, settings, scale > 0 ? scale : 1.0}, sweeps, most};
    if (method_ != settings.method) {
        iteration_ = make_iteration<D>(settings.method, sweep_);
        method_ = settings.method;
    }
    iteration_->begin(task.problem);
    SolveReport report;
    bool within = false;
    while (report.sweeps < most && !within) {
        const bool timed = time_tiles_ && report.sweeps == 0;
        const int n = timed ? 1 : next_halt(report.sweeps, task) - report.sweeps;
        if (timed) {
            tile_seconds_.resize(contacts.n_tiles());
            sweep_.time_into(&tile_seconds_);
        }
        const auto work = iteration_->advance(task.problem, n);
        sweep_.time_into(nullptr);
        report.sweeps += n;
        report.relaxations += work.relaxations;
        report.reductions += work.reductions;
        if (settings.tolerance && is_checked(report.sweeps, task)) {
            iteration_->settle(task.problem);
        }
        within = settings.tolerance && stops_after(report.sweeps, task);
    }
    iteration_->settle(task.problem);
    if (settings.tolerance && !within) { // no sweep left to hide this one behind
        within = std::sqrt(comm_.max(largest_squared(task))) / task.problem.unit <= *settings.tolerance;
    }
    report.converged = within || !settings.tolerance;
    return report;
}

template <int D>
bool ContactSolver<D>::is_checked(int sweep, const Task& task) {
    const auto& settings = task.problem.settings;
    return sweep >= task.least && sweep % settings.check_every == 0 && sweep + check_lag(settings) <= task.most;
}

/// The first sweep after k at which something is to be measured or decided.
template <int D>
int ContactSolver<D>::next_halt(int k, const Task& task) {
    const auto& settings = task.problem.settings;
    if (!settings.tolerance) {
        return task.most;
    }
    do {
        ++k;
    } while (k < task.most && !is_checked(k, task) && !is_checked(k - check_lag(settings), task));
    return k;
}

/// Whether sweep k is the last: one check is under way at a time, since the lag is no longer than the time between two.
template <int D>
bool ContactSolver<D>::stops_after(int k, const Task& task) {
    const auto& settings = task.problem.settings;
    const int lag = check_lag(settings);
    const auto agreed = [&] {
        const auto lap = watch_.lap(Timed::exchange);
        return std::sqrt(agreeing_.take()) / task.problem.unit <= *settings.tolerance;
    };
    if (lag > 0 && is_checked(k - lag, task) && agreed()) {
        return true;
    }
    if (is_checked(k, task)) {
        agreeing_.start(comm_, largest_squared(task));
        return lag == 0 && agreed();
    }
    return false;
}

template <int D>
double ContactSolver<D>::largest_squared(const Task& task) {
    const auto lap = watch_.lap(Timed::residual);
    double largest = 0;
    for (std::size_t t = 0; t < task.problem.contacts.n_tiles(); ++t) {
        const double of_tile = task.problem.contacts.residual(t, task.problem.u).largest_squared;
        largest = of_tile > largest ? of_tile : largest;
    }
    return largest;
}

template <int D>
Residual ContactSolver<D>::residual(const ContactsOf<D>& contacts, const std::vector<BodyVelocity<D>>& u,
                                    double scale) {
    const auto lap = watch_.lap(Timed::residual);
    double largest = 0;
    ExactSum squares;
    std::int64_t n = 0;
    for (std::size_t t = 0; t < contacts.n_counted_tiles(); ++t) {
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

template class ContactSolver<2>;

} // namespace nappe
