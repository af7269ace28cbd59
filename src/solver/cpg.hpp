#pragma once
// Conjugate projected gradient of Renouf and Alart 2005 (seeds/000 names it), preconditioned by the contacts' own blocks W:
// with g = -(u + b) the gradient, T the projection on the cone of directions that the law leaves open at r,
//     z = T(g / W),   p = z + beta T(p),   beta = -(z, N p) / (p, N p),   alpha = (g, p) / (p, N p),
//     r <- P(r + alpha p),   N = H^T M^-1 H.
// N p is never formed: with w = M^-1 H p, (z, N p) is a scalar product of velocities by mass. An iteration passes three
// times over the contacts (z, p, r) and counts as three relaxations each. Friction's bounds follow the normal impulses of
// the iterate, so a fixed point is exact Signorini–Coulomb; there is no proof of convergence with friction.

#include "solver/look_back.hpp"

namespace nappe {

template <int D>
class Cpg : public Iteration<D> {
public:
    explicit Cpg(TileSweep<D>& sweep) : sweep_(sweep) {}
    void begin(const ContactProblem<D>& problem) override;
    IterationWork advance(const ContactProblem<D>& problem, int n) override;
    std::size_t bytes_of_bodies() const override { return bytes_of(of_z_, of_p_); }

private:
    void iterate(const ContactProblem<D>& problem);

    TileSweep<D>& sweep_;
    std::vector<BodyVelocity<D>> of_z_, of_p_; ///< M⁻¹ H z and M⁻¹ H p
    double curvature_ = 0;                     ///< (p, N p) of the last iteration, 0: begin anew [J]
    double scale_ = 0;                         ///< of (g, z) [J]
};

} // namespace nappe
