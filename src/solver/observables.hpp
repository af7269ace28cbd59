#pragma once
// What is read off a running scene between steps; every figure is the same on any number of ranks.

#include "core/measures/surface.hpp"
#include "core/rows.hpp"
#include "solver/simulation.hpp"

#include <vector>

namespace nappe {

struct Energies {
    double kinetic = 0;   ///< [J]
    double potential = 0; ///< of gravity, 0 at the scene's origin [J]
};

/// **Collective.**
template <int D>
Energies energies(const Simulation<D>& simulation);

struct Overlaps {
    double mean = 0;           ///< of contacts that carry an impulse: max(-gap, 0) over the smaller radius
    double largest = 0;        ///< of all candidates
    std::int64_t contacts = 0; ///< that carry an impulse
    std::int64_t candidates = 0;
};

/// **Collective.** At the end of the step.
template <int D>
Overlaps overlaps(const Simulation<D>& simulation);

/// What a tracked set of grains looks like.
template <int D>
struct CellShape {
    std::int64_t grains = 0;
    double volume = 0;              ///< of the grains themselves [m²]
    Vec<D> extent = Vec<D>::Zero(); ///< largest minus smallest coordinate of centres (seeds/000 eq. 11) [m]
};

/// **Collective.** One per cell of the scene.
template <int D>
std::vector<CellShape<D>> cell_shapes(const Simulation<D>& simulation);

/// **Collective.** Empty if there is no grain, or if grains lie farther apart than a million bins.
template <int D>
Surface free_surface(const Simulation<D>& simulation, double bin);

/// **Collective.** This rank's rows of a frame.
template <int D>
std::vector<FrameGrain<D>> frame_grains(const Simulation<D>& simulation);

/// Local. Owned contacts with an impulse or an overlap.
template <int D>
std::vector<FrameContact<D>> frame_contacts(const Simulation<D>& simulation);

} // namespace nappe
