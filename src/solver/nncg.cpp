#include "solver/nncg.hpp"

namespace nappe {

namespace {

/// u <- u + beta p, p <- beta p + u - from, from <- u: the velocities of y_k+1.
template <int D>
void move_along(std::vector<BodyVelocity<D>>& u, std::vector<BodyVelocity<D>>& from,
                std::vector<BodyVelocity<D>>& direction, double beta) {
    const auto move = [beta](double& now, double& start, double& p) {
        const double ahead = beta * p;
        p = ahead + (now - start);
        now += ahead;
        start = now;
    };
    for (std::size_t i = 0; i < u.size(); ++i) {
        for (int d = 0; d < D; ++d) {
            move(u[i].v[d], from[i].v[d], direction[i].v[d]);
        }
        for (int k = 0; k < n_spin<D>; ++k) {
            move(u[i].s[k], from[i].s[k], direction[i].s[k]);
        }
    }
}

} // namespace

template <int D>
void Nncg<D>::begin(const ContactProblem<D>& problem) {
    problem.contacts.remember(2);
    from_ = problem.u;
    direction_.assign(problem.u.size(), {});
    squared_ = kinetic(sweep_, problem.u);
    beta_ = 0;
    first_ = true;
}

template <int D>
IterationWork Nncg<D>::advance(const ContactProblem<D>& problem, int n) {
    for (int k = 0; k < n; ++k) {
        move_along(problem.u, from_, direction_, beta_);
        PassSums sums(squared_);
        sweep_.run(1, 1, problem.halo, problem.u, [&](std::size_t t, std::size_t next) {
            sums.add(
                problem.contacts.counted(t, problem.contacts.relax_along(t, next, beta_, sums.rounding(), problem.u)));
        });
        sums.share(sweep_);
        const double squared = sums.squared.value();
        beta_ = !first_ && squared <= squared_ ? squared / squared_ : 0.0;
        squared_ = squared > 0 ? squared : squared_ * rounded_off;
        first_ = false;
    }
    return {n * problem.contacts.n_active(), n};
}

template class Nncg<2>;

} // namespace nappe
