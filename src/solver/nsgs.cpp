#include "solver/nsgs.hpp"

#include "core/exact_sum.hpp"

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
    SolveReport report;
    const int most = settings.tolerance ? settings.max_sweeps : sweeps;
    while (report.sweeps < most) {
        pass(halo, u, [&](std::size_t t) { contacts.relax(t, u); });
        ++report.sweeps;
        report.relaxations += contacts.n_active();
        if (settings.tolerance && report.sweeps >= sweeps &&
            (report.sweeps % settings.check_every == 0 || report.sweeps == most)) {
            report.converged = residual(contacts, u, scale).largest <= *settings.tolerance;
            if (report.converged) {
                break;
            }
        }
    }
    return report;
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
