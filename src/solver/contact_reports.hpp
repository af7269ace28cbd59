#pragma once
// What the contacts of a rank tell about themselves.

#include "core/types.hpp"

#include <cstdint>
#include <limits>

namespace nappe {

/// Distances between convergence and truth: largest and RMS of |W (r - P(r - u/W))| over active contacts [m/s], to be
/// divided by a velocity scale (docs/notation.md, "residual").
struct RawResidual {
    double largest_squared = 0;
    double sum_squared = 0; ///< of one tile, in the order of its contacts
    std::int64_t contacts = 0;
};

/// What packing met; ids rather than exceptions, since all ranks must hear of it together.
struct PackFaults {
    static constexpr GlobalId none = std::numeric_limits<GlobalId>::max();
    GlobalId through_wall = none; ///< lowest id of a grain whose centre went through a wall
    int wall = -1;
};

} // namespace nappe
