#pragma once
// Accelerated non-smooth Gauss–Seidel: Nesterov's momentum around the sweep of NSGS. With z_k what sweep k leaves and y_k
// what it starts from,
//     y_k+1 = z_k + beta_k (z_k - z_k-1),   beta_k = theta_k (1 - theta_k) / (theta_k² + theta_k+1),
//     theta_k+1² = (1 - theta_k+1) theta_k²
// as in Nesterov 1983. Momentum is dropped, and theta doubled, where it leads uphill: if (z - y)·(z_k - z_k-1) < 0
// (O'Donoghue and Candès 2015), or if the step |z - y|² is more than twice the smallest since the last such restart; both
// in the metric of the contacts' own blocks W. Departs from both sources in that the step is a sweep, not a gradient, and
// theta is doubled instead of put to 1. A fixed point is one of NSGS: exact Signorini–Coulomb. No proof of convergence is
// known to us, as for NSGS with friction; docs/accuracy.md has what was measured.

#include "solver/look_back.hpp"
#include "solver/momentum_schedule.hpp"

namespace nappe {

template <int D>
class Ansgs : public Iteration<D> {
public:
    explicit Ansgs(TileSweep<D>& sweep) : sweep_(sweep) {}
    void begin(const ContactProblem<D>& problem) override;
    IterationWork advance(const ContactProblem<D>& problem, int n) override;
    std::size_t bytes_of_bodies() const override { return bytes_of(before_); }

private:
    TileSweep<D>& sweep_;
    std::vector<BodyVelocity<D>> before_; ///< velocities that belong to z_k-1
    MomentumSchedule schedule_;
};

} // namespace nappe
