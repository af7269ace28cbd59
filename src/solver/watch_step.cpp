// What is looked at in every (sub)step before it is accepted ([watch]): all grains, in the pass that looks whether lists
// last, and of overlaps no more than a bound as long as that is enough. What is found is named in watch_causes.cpp.

#include "core/error.hpp"
#include "solver/simulation.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace nappe {

namespace {

struct EnergyGauge {
    double grown = 0, kinetic = 0; ///< [J]
    double farthest_squared = 0;   ///< [m²]
};

template <int D, bool several>
EnergyGauge gauge_grains(const State<D>& state, const Vec<D>& gravity, const Tile& tile, double h, double theta,
                         const StepStart<D>* start) {
    const double before = h * (1 - theta), after = h * theta;
    std::array<double, D> g;
    for (int d = 0; d < D; ++d) {
        g[d] = gravity[d];
    }
    const BodyVelocity<D>* const u_end = state.u.data();
    const BodyVelocity<D>* const u_start = several ? start->u.data() : state.u_old.data();
    const double* const mass = state.mass.data();
    double grown = 0, kinetic = 0, farthest = 0;
    for (LocalId i = tile.grains_begin; i < tile.grains_end; ++i) {
        const BodyVelocity<D>&u = u_end[i], &from = u_start[i];
        double now = 0, then = 0, fallen = 0, way2 = 0;
        for (int d = 0; d < D; ++d) {
            double since = after * u.v[d]; // from the last detection; `detected`: from the one of the normals
            if constexpr (several) {
                since += state.mid[i].x[d] - start->x[i][d];
            }
            const double way = several ? since : since + before * from.v[d];
            const double detected = several ? since - before * from.v[d] : since;
            now += u.v[d] * u.v[d];
            then += from.v[d] * from.v[d];
            fallen += g[d] * way;
            way2 += detected * detected;
        }
        for (int k = 0; k < n_spin<D>; ++k) {
            now += 0.5 * u.s[k] * u.s[k]; // I = m r²/2
            then += 0.5 * from.s[k] * from.s[k];
        }
        grown += mass[i] * (0.5 * (now - then) - fallen);
        kinetic += 0.5 * mass[i] * then;
        farthest = way2 > farthest ? way2 : farthest;
    }
    return {grown, kinetic, farthest};
}

} // namespace

/// Energies of a tile's grains, the longest way that one goes between detection and the end of the (sub)steps, and
/// centres outside the scene's bounds.
template <int D>
void Simulation<D>::gauge(const Tile& tile, double h, const StepStart<D>* start) {
    // Apart, so that the loop of a step with one substep reads velocities and masses and nothing else.
    const EnergyGauge found = start != nullptr
                                  ? gauge_grains<D, true>(state_, scene_.gravity, tile, h, settings().theta, start)
                                  : gauge_grains<D, false>(state_, scene_.gravity, tile, h, settings().theta, start);
    const auto [grown, kinetic, farthest] = found;
    gauge_.finite = gauge_.finite && std::isfinite(grown) && std::isfinite(kinetic);
    gauge_.farthest_squared = farthest > gauge_.farthest_squared ? farthest : gauge_.farthest_squared;
    gauge_.grown.add(grown);
    gauge_.kinetic.add(kinetic);
    if (const auto& bounds = scene_.watch.bounds) {
        for (LocalId i = tile.grains_begin; i < tile.grains_end; ++i) {
            const Vec<D> x = end_of(i, h);
            if (((x.array() < bounds->min.array()) || (x.array() > bounds->max.array())).any()) {
                Suspect out = suspect(0, i, -1);
                for (int d = 0; d < D; ++d) {
                    out.place[static_cast<std::size_t>(d)] = x[d] + scene_.origin[d];
                }
                gauge_.outside = out.worse_than(gauge_.outside) ? out : gauge_.outside;
            }
        }
    }
}

/// Flags of this rank from what `gauge` found in all of its tiles.
template <int D>
std::uint32_t Simulation<D>::read_gauge(double h, int n, const StepStart<D>* start) {
    std::uint32_t flags = gauge_.finite ? 0 : flag::not_finite;
    flags |= gauge_.outside.measure < 0 ? 0 : flag::outside;
    // Two surfaces come nearer by no more than both go.
    double farthest2 = gauge_.farthest_squared;
    for (LocalId i = state_.n_own; i < state_.n_held(); ++i) {
        double way2 = 0;
        for (int d = 0; d < D; ++d) {
            const double since =
                start != nullptr ? state_.mid[i].x[d] - start->x[i][d] - h * (1 - settings().theta) * start->u[i].v[d]
                                 : 0.0;
            const double way = since + h * settings().theta * state_.u[i].v[d];
            way2 += way * way;
        }
        farthest2 = way2 > farthest2 ? way2 : farthest2;
    }
    double farthest = std::sqrt(farthest2);
    if (corrects()) {
        double most = 0;
        for (LocalId i = 0; i < state_.n_held(); ++i) {
            double w2 = 0;
            for (int d = 0; d < D; ++d) {
                w2 += correction_[i].v[d] * correction_[i].v[d];
            }
            most = w2 > most ? w2 : most;
        }
        farthest += h * std::sqrt(most);
    }
    double of_walls = 0;
    for (const auto& v : walls_.v) {
        const double way = n * h * v.norm();
        of_walls = way > of_walls ? way : of_walls;
    }
    const double nearer = (farthest + (farthest > of_walls ? farthest : of_walls)) / r_min_;
    const double limit = scene_.watch.overlap.limit;
    if (!((contacts_.deepest() + nearer) * (1 + 1e-9) <= limit) && gauge_.finite) {
        gauge_.deep = deepest(h);
        flags |= gauge_.deep.measure > limit ? flag::deep : 0;
    }
    return flags;
}

/// Where a grain is at the end of the substep [m].
template <int D>
Vec<D> Simulation<D>::end_of(LocalId i, double h) const {
    Vec<D> x;
    for (int d = 0; d < D; ++d) {
        const double apart = corrects() ? h * correction_[i].v[d] : 0.0;
        x[d] = state_.mid[i].x[d] + h * settings().theta * state_.u[i].v[d] + apart;
    }
    return x;
}

/// The pair that overlaps most at the end of the substep, over the smaller radius.
template <int D>
Suspect Simulation<D>::deepest(double h) const {
    Suspect found;
    for (std::int32_t c = 0; c < candidates_.size(); ++c) {
        const LocalId a = candidates_.a[c], b = candidates_.b[c];
        const Vec<D> x = end_of(a, h);
        double overlap = 0;
        if (b < state_.n_held()) {
            const double smaller = state_.radius[a] < state_.radius[b] ? state_.radius[a] : state_.radius[b];
            const double touching = state_.radius[a] + state_.radius[b];
            const double distance2 = (x - end_of(b, h)).squaredNorm();
            if (distance2 < touching * touching) {
                overlap = (touching - std::sqrt(distance2)) / smaller;
            }
        } else {
            const int sided = b - state_.n_held();
            const auto& v = walls_.v[static_cast<std::size_t>(walls_.feature(sided).wall)];
            const auto g = walls_.contact(sided, x - h * settings().theta * v, state_.radius[a]);
            overlap = g.applies ? 1 - g.distance / state_.radius[a] : 0.0;
        }
        if (overlap > 0 && overlap >= found.measure) {
            const Suspect now = suspect(overlap, a, b);
            found = now.worse_than(found) ? now : found;
        }
    }
    return found;
}

template <int D>
bool Simulation<D>::may_divide(typename WatchSettings<D>::Then then) const {
    return then == WatchSettings<D>::Then::substep && !preparing() && 2 * parts_ <= scene_.watch.max_substeps;
}

/// **Collective.** What becomes of (sub)steps that can be taken, as the scene says. False: the whole step is to be done
/// again with more substeps. Throws NumericalFailure. @param energies whether all ranks have
/// gauged what their grains gained
template <int D>
bool Simulation<D>::heed(double h, int n, const StepStart<D>* start, EnergyLook energies) {
    using Then = typename WatchSettings<D>::Then;
    const auto lap = watch_.lap(Timed::check);
    const auto& wanted = scene_.watch;
    const double growth = energies == EnergyLook::none ? 0.0 : energy_growth(h, n, start, energies);
    std::int64_t in_row = watcher_.memory().unconverged_in_row;
    if (done_ + n == parts_ && settings().tolerance) {
        in_row = counters_.unconverged > unconverged_before_ ? in_row + 1 : 0;
    }
    const struct {
        Watched what;
        bool found;
        Then then;
    } looks[] = {
        {Watched::overlap, (agreed_ & flag::deep) != 0, wanted.overlap.then},
        {Watched::energy, growth > wanted.energy.limit, wanted.energy.then},
        {Watched::residual, done_ + n == parts_ && in_row >= wanted.residual.steps, wanted.residual.then},
        {Watched::bounds, (agreed_ & flag::outside) != 0, wanted.bounds ? wanted.bounds->then : Then::warn},
    };
    for (const auto& look : looks) {
        if (look.found && may_divide(look.then)) {
            return false;
        }
    }
    watcher_.note_growth(growth);
    watcher_.set_unconverged_in_row(in_row);
    for (const auto& look : looks) {
        if (!look.found) {
            continue;
        }
        if (look.then == Then::stop || (look.then == Then::substep && !preparing())) {
            throw NumericalFailure(cause(look.what, growth));
        }
        if (watcher_.count(look.what)) {
            watcher_.tell(look.what, cause(look.what, growth));
        }
    }
    return true;
}

template void Simulation<2>::gauge(const Tile&, double, const StepStart<2>*);
template std::uint32_t Simulation<2>::read_gauge(double, int, const StepStart<2>*);
template bool Simulation<2>::heed(double, int, const StepStart<2>*, EnergyLook);
template bool Simulation<2>::may_divide(WatchSettings<2>::Then) const;
template Vec<2> Simulation<2>::end_of(LocalId, double) const;

} // namespace nappe
