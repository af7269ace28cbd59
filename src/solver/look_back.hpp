#pragma once
// What methods that look back share: their sums over all contacts, and velocities moved on along with the impulses.

#include "solver/iteration.hpp"
#include "solver/rounded_sum.hpp"

#include <vector>

namespace nappe {

/// Sums of one pass over all contacts of all ranks [J].
struct PassSums {
    explicit PassSums(double scale) : squared(scale), along(scale) {}
    RoundedSum squared, along;

    TermRounding rounding() const { return squared.rounding(); }

    /// Local.
    void add(const StepSums& of_tile) {
        squared.add(of_tile.squared);
        along.add(of_tile.along);
    }

    /// **Collective.** One reduction.
    template <int D>
    void share(TileSweep<D>& sweep) {
        const auto lap = sweep.watch().lap(Timed::exchange);
        std::int64_t units[] = {squared.units(), along.units()};
        sweep.comm().sum(units);
        squared.units() = units[0];
        along.units() = units[1];
    }
};

/// Local.
template <class... Bodies>
std::size_t bytes_of(const std::vector<Bodies>&... arrays) {
    return (... + (arrays.size() * sizeof(Bodies)));
}

/// **Collective.** Sum over all grains of m (v·w + s z / 2) [J], s = r x spin: with I = m r²/2, the scalar product by mass.
template <int D>
double product(TileSweep<D>& sweep, const std::vector<BodyVelocity<D>>& p, const std::vector<BodyVelocity<D>>& q) {
    return sweep.sum_over_grains([&](LocalId i) {
        double sum = 0;
        for (int d = 0; d < D; ++d) {
            sum += p[i].v[d] * q[i].v[d];
        }
        for (int k = 0; k < n_spin<D>; ++k) {
            sum += 0.5 * (p[i].s[k] * q[i].s[k]);
        }
        return sum / p[i].inv_m;
    });
}

/// **Collective.** |u|² by mass, twice the kinetic energy [J].
template <int D>
double kinetic(TileSweep<D>& sweep, const std::vector<BodyVelocity<D>>& u) {
    return product(sweep, u, u);
}

/// **Collective.** |u - w|² by mass [J].
template <int D>
double kinetic(TileSweep<D>& sweep, const std::vector<BodyVelocity<D>>& u, const std::vector<BodyVelocity<D>>& w) {
    return sweep.sum_over_grains([&](LocalId i) {
        double sum = 0;
        for (int d = 0; d < D; ++d) {
            const double by = u[i].v[d] - w[i].v[d];
            sum += by * by;
        }
        for (int k = 0; k < n_spin<D>; ++k) {
            const double by = u[i].s[k] - w[i].s[k];
            sum += 0.5 * (by * by);
        }
        return sum / u[i].inv_m;
    });
}

/// Local. u <- u + beta (u - before), before <- u. Of all bodies held: copies stay equal, and walls keep their speed.
template <int D>
void move_on(std::vector<BodyVelocity<D>>& u, std::vector<BodyVelocity<D>>& before, double beta) {
    for (std::size_t i = 0; i < u.size(); ++i) {
        const BodyVelocity<D> now = u[i];
        for (int d = 0; d < D; ++d) {
            u[i].v[d] += beta * (now.v[d] - before[i].v[d]);
        }
        for (int k = 0; k < n_spin<D>; ++k) {
            u[i].s[k] += beta * (now.s[k] - before[i].s[k]);
        }
        before[i] = now;
    }
}

} // namespace nappe
