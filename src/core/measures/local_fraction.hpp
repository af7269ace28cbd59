#pragma once
// The coarse-grained solid fraction where grains are: phi(x_i) = sum over grains j of A_j W(|x_i - x_j|), W the kernel
// of Lucy 1977 in the plane, 5/(pi w²) (1 + 3 r/w) (1 - r/w)³ for r < w, whose integral is 1 (docs/measures.md).

#include "core/types.hpp"

#include <span>
#include <vector>

namespace nappe {

/// A disk as the field sees it. Trivially copyable.
struct FieldGrain {
    GlobalId id = 0;
    double x = 0, y = 0;   ///< [m]
    double radius = 0;     ///< [m]
    bool is_target = true; ///< false: only its area is asked for
};

/// Local. phi at the centre of each grain that is a target, in the order of `grains`, from the areas of all. Sums run
/// in the order of `grains`: let that be the order of ids. @param range w [m], > 0
std::vector<double> local_solid_fractions(std::span<const FieldGrain> grains, double range);

} // namespace nappe
