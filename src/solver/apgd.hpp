#pragma once
// Accelerated projected gradient (Mazhar, Heyn, Negrut and Tasora 2015, after Nesterov 1983), scaled by the contacts' own
// blocks W: all contacts are projected at the velocities of y_k at once,
//     z_k = P(y_k - (u(y_k) + b) / (L W)),   y_k+1 = z_k + beta_k (z_k - z_k-1),
// beta_k and its restarts as in ansgs.hpp. L has to be at least the largest eigenvalue of W^-1 H^T M^-1 H: each step shows a
// lower bound of it, |u(z) - u(y)|²_M / |z - y|²_W, and L grows to it and a tenth more (the source: a line search that
// repeats the step). P is the law itself, friction bounded by the new normal impulse: a fixed point is exact
// Signorini–Coulomb, as for NSGS. The source solves the cone complementarity problem instead, in which sliding contacts open
// at mu |v_t|; for that there is a proof of convergence, for ours there is none.

#include "solver/look_back.hpp"
#include "solver/momentum_schedule.hpp"

namespace nappe {

template <int D>
class Apgd : public Iteration<D> {
public:
    explicit Apgd(TileSweep<D>& sweep) : sweep_(sweep) {}
    void begin(const ContactProblem<D>& problem) override;
    IterationWork advance(const ContactProblem<D>& problem, int n) override;
    std::size_t bytes_of_bodies() const override { return bytes_of(before_, at_); }

private:
    TileSweep<D>& sweep_;
    std::vector<BodyVelocity<D>> before_; ///< velocities that belong to z_k-1
    std::vector<BodyVelocity<D>> at_;     ///< to y_k
    MomentumSchedule schedule_;
    double steepest_ = 1; ///< L
};

} // namespace nappe
