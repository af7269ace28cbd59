#include "solver/nsgs.hpp"

namespace nappe {

template <int D>
void Nsgs<D>::begin(const ContactProblem<D>& problem) {
    problem.contacts.remember(0);
    const auto bytes = problem.contacts.bytes_swept() + problem.u.size() * sizeof(BodyVelocity<D>);
    together_ = sweep_.together(static_cast<double>(bytes));
}

template <int D>
IterationWork Nsgs<D>::advance(const ContactProblem<D>& problem, int n) {
    sweep_.run(n, together_, problem.halo, problem.u,
               [&](std::size_t t, std::size_t next) { problem.contacts.relax(t, next, problem.u); });
    return {n * problem.contacts.n_active(), 0};
}

template class Nsgs<2>;

} // namespace nappe
