#pragma once
// The trishear model of fault-propagation folds (Erslev 1991; velocities: Zehnder & Allmendinger 2000, J. Struct. Geol.
// 22, 1009, eq. 6), and its fit to a measured velocity field. Local.
//
// Origin at the fault's tip, xi along the fault, eta to its upper side, m = tan(half the apical angle),
// u = |eta| / (m xi):
//     |eta| < m xi:  v_xi  = V0/2 [sgn(eta) u^(1/s) + 1],  v_eta = V0/2 m/(1+s) [u^((1+s)/s) - 1]
//     above: (V0, 0);  below: (0, 0)
// Without divergence and continuous at both limits; s = 1 is linear in eta, a larger s turns in a narrower middle.

#include "core/types.hpp"

#include <array>
#include <span>

namespace nappe {

struct Trishear {
    Vec<2> tip = Vec<2>::Zero(); ///< [m]
    double m = 1;                ///< tangent of half the apical angle
    double s = 1;                ///< concentration, >= 1
};

/// Velocity at x [m/s]. @param drive V0 [m/s]: its direction is the fault's, the block above the fault moves with it.
Vec<2> trishear_velocity(const Trishear& model, const Vec<2>& drive, const Vec<2>& x);

/// Whether x is in the sheared zone, neither in the block nor at rest.
bool trishear_inside(const Trishear& model, const Vec<2>& drive, const Vec<2>& x);

/// A measured velocity. Trivially copyable.
struct VelocityAt {
    std::array<double, 2> x{}; ///< [m]
    std::array<double, 2> v{}; ///< [m/s]
};

struct TrishearFit {
    Trishear model;      ///< NaN if nothing was found
    double residual = 0; ///< root mean square of |v - model| over |V0|
    /// The same of data inside the model's zone alone, which does not depend on how much of the rest is looked at; NaN if
    /// none is inside.
    double residual_inside = 0;
};

/// Where the unknowns are sought. Without bounds on the tip, a zone of parallel shear is fitted best by an ever
/// narrower wedge from ever farther away.
struct TrishearBounds {
    Vec<2> tip = Vec<2>::Zero(); ///< in the middle of where tips are sought [m]
    double reach = 1;            ///< they lie so far from it at most, along x and along y [m]
    double least_m = 0.02, largest_m = 5;
    double least_s = 1, largest_s = 20;
};

/// Least squares of all components by Levenberg–Marquardt, tip, m and s free within bounds, from six starts at the tip
/// given. A figure at its bound says that the model does not hold. The same data give the same bits.
TrishearFit fit_trishear(std::span<const VelocityAt> data, const Vec<2>& drive, const TrishearBounds& bounds);

} // namespace nappe
