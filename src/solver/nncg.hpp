#pragma once
// Nonsmooth nonlinear conjugate gradient around the sweep of NSGS (Silcowitz-Hansen, Niebe and Erleben 2010): a sweep
// from y_k leaves z_k, the change d_k = z_k - y_k is the gradient's stand-in, and
//     p_k = d_k + beta_k p_k-1,   y_k+1 = z_k + beta_k p_k-1,   beta_k = |d_k|² / |d_k-1|²  (Fletcher–Reeves),
// restarted with p_k = d_k where beta_k > 1. |d|² is taken in the metric of the contacts' own blocks W, which makes it
// independent of units and masses (the source: plain). A fixed point is one of NSGS: exact Signorini–Coulomb.

#include "solver/look_back.hpp"

namespace nappe {

template <int D>
class Nncg : public Iteration<D> {
public:
    explicit Nncg(TileSweep<D>& sweep) : sweep_(sweep) {}
    void begin(const ContactProblem<D>& problem) override;
    IterationWork advance(const ContactProblem<D>& problem, int n) override;
    std::size_t bytes_of_bodies() const override { return bytes_of(from_, direction_); }

private:
    TileSweep<D>& sweep_;
    std::vector<BodyVelocity<D>> from_;      ///< velocities that belong to y_k
    std::vector<BodyVelocity<D>> direction_; ///< those of p_k
    double squared_ = 0;                     ///< |d|² of the last sweep; before the first, what it may be like [J]
    double beta_ = 0;
    bool first_ = true;
};

} // namespace nappe
