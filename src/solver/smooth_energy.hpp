#pragma once
// What is read off a scene with smooth contacts between steps; the same on any number of ranks.

#include "solver/simulation.hpp"

namespace nappe {

/// **Collective.** Held by springs where things stand now: k_n d²/2 of what overlaps, and s²/(2 k_s) [J]. Pre: the last
/// step was smooth, or impulses are of its h.
template <int D>
double elastic_energy(const Simulation<D>& simulation);

/// **Collective.** Of the last (sub)step, which was smooth: the sum over grains of the resultant force, over that of all
/// forces that act on them, weights and contacts (global damping is none of them).
template <int D>
double unbalanced_force(const Simulation<D>& simulation);

} // namespace nappe
