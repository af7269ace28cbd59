#include "solver/apgd.hpp"

namespace nappe {

template <int D>
void Apgd<D>::begin(const ContactProblem<D>& problem) {
    problem.contacts.remember(1);
    before_ = problem.u;
    schedule_ = MomentumSchedule(kinetic(sweep_, problem.u));
    steepest_ = 1;
}

template <int D>
IterationWork Apgd<D>::advance(const ContactProblem<D>& problem, int n) {
    for (int k = 0; k < n; ++k) {
        const double beta = schedule_.beta();
        move_on(problem.u, before_, beta);
        at_ = problem.u;
        PassSums sums(schedule_.scale());
        sweep_.run(1, 1, problem.halo, problem.u, [&](std::size_t t, std::size_t) {
            sums.add(problem.contacts.counted(
                t, problem.contacts.project(t, beta, 1 / steepest_, sums.rounding(), at_, problem.u)));
        });
        sums.share(sweep_);
        const double moved = kinetic(sweep_, problem.u, at_), stepped = sums.squared.value();
        constexpr double rounding = 1.001; // of sums: a bound that is reached is no sign of a larger one
        if (moved > rounding * steepest_ * stepped && stepped > 0) {
            steepest_ = 1.1 * moved / stepped;
            schedule_.restart();
        } else {
            schedule_.next(stepped, sums.along.value());
        }
    }
    return {n * problem.contacts.n_active(), 2 * n};
}

template class Apgd<2>;

} // namespace nappe
