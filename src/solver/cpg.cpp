#include "solver/cpg.hpp"

namespace nappe {

namespace {

/// No velocity, the masses of u.
template <int D>
void lay_at_rest(const std::vector<BodyVelocity<D>>& u, std::vector<BodyVelocity<D>>& rest) {
    rest.resize(u.size());
    for (std::size_t i = 0; i < u.size(); ++i) {
        rest[i] = {};
        rest[i].inv_m = u[i].inv_m;
    }
}

} // namespace

template <int D>
void Cpg<D>::begin(const ContactProblem<D>& problem) {
    problem.contacts.remember(2);
    curvature_ = 0;
    scale_ = kinetic(sweep_, problem.u);
}

template <int D>
void Cpg<D>::iterate(const ContactProblem<D>& problem) {
    auto& contacts = problem.contacts;
    lay_at_rest(problem.u, of_z_);
    PassSums of_gradient(scale_);
    sweep_.run(1, 1, problem.halo, of_z_, [&](std::size_t t, std::size_t) {
        of_gradient.add(contacts.counted(t, contacts.gradient(t, of_gradient.rounding(), problem.u, of_z_)));
    });
    of_gradient.share(sweep_);
    if (!(of_gradient.squared.value() > 0)) {
        scale_ *= rounded_off; // or solved
        curvature_ = 0;
        return;
    }
    scale_ = of_gradient.squared.value();
    const double coupled = curvature_ > 0 ? product(sweep_, of_z_, of_p_) / curvature_ : 0.0;
    const double beta = coupled < 0 ? -coupled : 0.0;
    lay_at_rest(problem.u, of_p_);
    PassSums of_direction(scale_);
    sweep_.run(1, 1, problem.halo, of_p_, [&](std::size_t t, std::size_t) {
        of_direction.add(contacts.counted(t, contacts.turn(t, beta, of_direction.rounding(), problem.u, of_p_)));
    });
    of_direction.share(sweep_);
    const double slope = of_direction.along.value();
    curvature_ = slope > 0 ? product(sweep_, of_p_, of_p_) : 0.0;
    const double alpha = curvature_ > 0 ? slope / curvature_ : 0.0; // 0: the next iteration begins along z
    sweep_.run(1, 1, problem.halo, problem.u,
               [&](std::size_t t, std::size_t) { contacts.go_along(t, alpha, problem.u); });
}

template <int D>
IterationWork Cpg<D>::advance(const ContactProblem<D>& problem, int n) {
    for (int k = 0; k < n; ++k) {
        iterate(problem);
    }
    return {3 * n * problem.contacts.n_active(), 4 * n};
}

template class Cpg<2>;

} // namespace nappe
