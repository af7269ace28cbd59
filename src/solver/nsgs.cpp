#include "solver/nsgs.hpp"

namespace nappe {

template <int D>
void Nsgs<D>::begin(const ContactProblem<D>& problem) {
    problem.contacts.remember(0);
    const bool single = problem.settings.precision == SolverSettings::Precision::single;
    const auto bytes = single
                           ? problem.contacts.bytes_swept_single() + problem.u.size() * sizeof(BodyVelocity<D, float>)
                           : problem.contacts.bytes_swept() + problem.u.size() * sizeof(BodyVelocity<D>);
    rounded_ = false;
    together_ = sweep_.together(static_cast<double>(bytes));
    const auto watched = problem.settings.adaptive ? problem.contacts.n_tiles() : 0;
    tile_sweeps_.assign(watched, 0);
    quiet_at_.resize(watched);
    for (auto& velocities : quiet_at_) {
        velocities.clear(); // and keeps its memory
    }
    clock_ = 0;
    relaxed_at_.assign(watched, 0);
    looked_at_.assign(watched, 0);
}

template <int D>
IterationWork Nsgs<D>::advance(const ContactProblem<D>& problem, int n) {
    auto& contacts = problem.contacts;
    if (problem.settings.precision == SolverSettings::Precision::single) {
        if (!rounded_) {
            round_off(problem);
        }
        sweep_.run(n, together_, problem.halo, u_single_,
                   [&](std::size_t t, std::size_t next) { contacts.relax_single(t, next, u_single_); });
        return {n * contacts.n_active(), 0};
    }
    if (!problem.settings.adaptive) {
        sweep_.run(n, together_, problem.halo, problem.u,
                   [&](std::size_t t, std::size_t next) { contacts.relax(t, next, problem.u); });
        return {n * contacts.n_active(), 0};
    }
    const double limit = *problem.settings.adaptive * problem.unit, limit_squared = limit * limit;
    std::int64_t relaxations = 0;
    sweep_.run(n, together_, problem.halo, problem.u, [&](std::size_t t, std::size_t next) {
        ++clock_;
        if (!quiet_at_[t].empty() && (undisturbed(t) || stays_quiet(t, problem.u, limit_squared))) {
            looked_at_[t] = clock_;
            return;
        }
        relaxed_at_[t] = clock_;
        quiet_at_[t].clear();
        if (contacts.relax_watched(t, next, problem.u) <= limit_squared) {
            note(t, problem.u);
            looked_at_[t] = clock_;
        }
        relaxations += contacts.n_active(t);
        ++tile_sweeps_[t];
    });
    return {relaxations, 0};
}

/// Whether nothing that could move a quiet tile's bodies was relaxed since the last look: then another look would say the
/// same. (Never known where other ranks may have moved them.)
template <int D>
bool Nsgs<D>::undisturbed(std::size_t tile) const {
    if (sweep_.shared(tile)) {
        return false;
    }
    for (const auto other : sweep_.around(tile)) {
        if (relaxed_at_[static_cast<std::size_t>(other)] > looked_at_[tile]) {
            return false;
        }
    }
    return true;
}

template <int D>
void Nsgs<D>::round_off(const ContactProblem<D>& problem) {
    problem.contacts.round_batches();
    u_single_.resize(problem.u.size());
    for (std::size_t i = 0; i < u_single_.size(); ++i) {
        for (int d = 0; d < D; ++d) {
            u_single_[i].v[d] = static_cast<float>(problem.u[i].v[d]);
        }
        for (int k = 0; k < n_spin<D>; ++k) {
            u_single_[i].s[k] = static_cast<float>(problem.u[i].s[k]);
        }
        u_single_[i].inv_m = static_cast<float>(problem.u[i].inv_m);
    }
    rounded_ = true;
}

template <int D>
void Nsgs<D>::settle(const ContactProblem<D>& problem) {
    if (rounded_) {
        sweep_.run(1, 1, problem.halo, problem.u,
                   [&](std::size_t t, std::size_t) { problem.contacts.settle_single(t, problem.u); });
        rounded_ = false;
    }
}

template <int D>
bool Nsgs<D>::stays_quiet(std::size_t tile, const std::vector<BodyVelocity<D>>& u, double limit_squared) const {
    const auto bodies = sweep_.bodies(tile);
    const auto& was = quiet_at_[tile];
    for (std::size_t k = 0; k < bodies.size(); ++k) {
        const auto& now = u[static_cast<std::size_t>(bodies[k])];
        double squared = 0;
        for (int d = 0; d < D; ++d) {
            squared += (now.v[d] - was[k].v[d]) * (now.v[d] - was[k].v[d]);
        }
        for (int d = 0; d < n_spin<D>; ++d) {
            squared += (now.s[d] - was[k].s[d]) * (now.s[d] - was[k].s[d]);
        }
        if (squared > limit_squared) {
            return false;
        }
    }
    return true;
}

template <int D>
void Nsgs<D>::note(std::size_t tile, const std::vector<BodyVelocity<D>>& u) {
    for (const LocalId i : sweep_.bodies(tile)) {
        quiet_at_[tile].push_back(u[static_cast<std::size_t>(i)]);
    }
}

template <int D>
std::size_t Nsgs<D>::bytes_of_bodies() const {
    std::size_t bytes = u_single_.size() * sizeof(BodyVelocity<D, float>);
    for (const auto& velocities : quiet_at_) {
        bytes += velocities.size() * sizeof(BodyVelocity<D>);
    }
    return bytes;
}

template class Nsgs<2>;

} // namespace nappe
