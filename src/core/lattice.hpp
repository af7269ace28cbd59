#pragma once
// Samples whose grains are in order: lattices of equal disks that just touch.

#include "core/rows.hpp"
#include "core/scene.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace nappe {

/// What is wrong with a sample that is to be a lattice, as "KEY: RULE, found VALUE; REMEDY" without the key's path above
/// "sample"; both empty if nothing is. Local.
struct LatticeFault {
    std::string key;  ///< "radius" or "profile"
    std::string text; ///< "must …, found …; …"
};
LatticeFault lattice_fault(const Sample<2>& sample);

/// Disks of one radius r in rows from the foot of a profile, which is a rectangle along the axes of width W and height H.
/// Square: floor(W/2r) columns, floor(H/2r) rows 2r apart. Staggered (hexagonal): rows of floor(W/2r) disks and of one
/// less by turns, sqrt(3) r apart, as many as lie within H. In either each row lies in the middle: what W has beyond whole
/// disks is left free at both sides alike, what H has at the top. (A width that whole disks fill to 1e-9 of a diameter
/// counts as filled.)
///
/// Rows have ids 0 … n-1 from the lowest up, in each from left to right. Velocity, spin and rotation are 0.
/// Local; + - * / and square roots only. Pre: lattice_fault finds none, density > 0.
std::vector<GrainRow<2>> lattice(const Sample<2>& sample, double density);

/// Local. How many grains it has. Pre: lattice_fault finds none.
std::int64_t lattice_size(const Sample<2>& sample);

} // namespace nappe
