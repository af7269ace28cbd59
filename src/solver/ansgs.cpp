#include "solver/ansgs.hpp"

namespace nappe {

template <int D>
void Ansgs<D>::begin(const ContactProblem<D>& problem) {
    problem.contacts.remember(1);
    before_ = problem.u;
    schedule_ = MomentumSchedule(kinetic(sweep_, problem.u));
}

template <int D>
IterationWork Ansgs<D>::advance(const ContactProblem<D>& problem, int n) {
    for (int k = 0; k < n; ++k) {
        const double beta = schedule_.beta();
        move_on(problem.u, before_, beta);
        PassSums sums(schedule_.scale());
        sweep_.run(1, 1, problem.halo, problem.u, [&](std::size_t t, std::size_t next) {
            sums.add(
                problem.contacts.counted(t, problem.contacts.relax_ahead(t, next, beta, sums.rounding(), problem.u)));
        });
        sums.share(sweep_);
        schedule_.next(sums.squared.value(), sums.along.value());
    }
    return {n * problem.contacts.n_active(), n};
}

template class Ansgs<2>;

} // namespace nappe
