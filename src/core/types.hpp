#pragma once
// Names of the numbers that every folder uses. Dimension D is a template parameter everywhere; 2 is instantiated.

#include <Eigen/Core>
#include <cstdint>

namespace nappe {

/// A grain's name for life: 0 … n-1 in the order the sample was made. Order anywhere is by GlobalId, never by LocalId.
using GlobalId = std::int64_t;

/// A row of this rank's arrays; means nothing on another rank or after the next rebuild.
using LocalId = std::int32_t;

/// Position [m], velocity [m/s], force [N] … DontAlign, so that arrays of them have no padding and any struct may hold
/// one.
template <int D>
using Vec = Eigen::Matrix<double, D, 1, Eigen::DontAlign>;

/// Rotations have D (D - 1) / 2 components: one in the plane, three in space.
template <int D>
inline constexpr int n_spin = D*(D - 1) / 2;

} // namespace nappe
