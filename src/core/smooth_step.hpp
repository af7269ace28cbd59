#pragma once
// How long a step of a smooth stage may be: springs and dashpots are integrated explicitly (seeds/004, annex §4).

#include "core/scene.hpp"

#include <limits>
#include <string>
#include <vector>

namespace nappe {

/// Of a whole scene, from its materials, laws and radii alone: what holds whatever comes to touch.
struct SmoothBounds {
    /// No step up to it lets an oscillation grow [s]: of all contacts at once (docs/notation.md, "Smooth contacts").
    double stable = std::numeric_limits<double>::infinity();
    std::string contact;        ///< of which pair
    double critical = stable;   ///< 2 sqrt(m_min / k_max), the seed's dt_crit, of one spring without a dashpot [s]
    double spin_flips = stable; ///< beyond it the spin damping of some grain turns its spin around [s]
    std::string spin;           ///< of which
};

/// Local. Pre: the scene's laws have springs.
SmoothBounds smooth_bounds(const Scene<2>& scene);

/// Local. What a user of the scene's smooth stages should know before the first step, a line each; nothing if all is well.
std::vector<std::string> smooth_warnings(const Scene<2>& scene);

} // namespace nappe
