#pragma once
// Where two bodies stand to each other at the positions State::mid and Walls::offset_mid: during a step the predicted
// ones, between steps those at its end.

#include "core/state.hpp"
#include "core/walls.hpp"

#include <cmath>

namespace nappe {

template <int D>
struct ContactGeometry {
    double gap = 0;            ///< [m], negative: overlap
    Vec<D> n = Vec<D>::Zero(); ///< unit normal from b to a
    bool applies = true;       ///< false: another part of the wall is nearer
    bool through = false;      ///< the centre of a has gone through a wall
};

/// Local. @param a row of a grain @param b row of a grain, or of a wall body.
template <int D>
ContactGeometry<D> contact_geometry(const State<D>& state, const Walls<D>& walls, LocalId a, LocalId b) {
    ContactGeometry<D> g;
    if (b < state.n_held()) {
        const Vec<D> d = state.mid[a].position() - state.mid[b].position();
        const double distance = std::sqrt(d.squaredNorm());
        g.n = d / distance;
        g.gap = distance - (state.radius[a] + state.radius[b]);
        return g;
    }
    const auto c = walls.contact(b - state.n_held(), state.mid[a].position(), state.radius[a]);
    g.applies = c.applies;
    g.through = c.through;
    g.n = c.n;
    g.gap = c.distance - state.radius[a];
    return g;
}

} // namespace nappe
