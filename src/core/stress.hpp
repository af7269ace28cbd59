#pragma once
// Principal values of a stress in the plane (seeds/000 eq. 8). Compression positive.

#include <Eigen/Core>

#include <cmath>

namespace nappe {

struct PrincipalStress {
    double p = 0; ///< mean stress (s1 + s2) / 2 [Pa]
    double q = 0; ///< deviatoric stress (s1 - s2) / 2 >= 0 [Pa]
};

/// Of the symmetric part of sigma.
inline PrincipalStress principal_stress(const Eigen::Matrix2d& sigma) {
    const double half_difference = 0.5 * (sigma(0, 0) - sigma(1, 1));
    const double shear = 0.5 * (sigma(0, 1) + sigma(1, 0));
    return {0.5 * (sigma(0, 0) + sigma(1, 1)), std::sqrt(half_difference * half_difference + shear * shear)};
}

} // namespace nappe
