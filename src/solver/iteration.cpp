#include "solver/iteration.hpp"

#include "solver/ansgs.hpp"
#include "solver/apgd.hpp"
#include "solver/cpg.hpp"
#include "solver/nncg.hpp"
#include "solver/nsgs.hpp"

namespace nappe {

template <int D>
std::unique_ptr<Iteration<D>> make_iteration(SolverSettings::Method method, TileSweep<D>& sweep) {
    switch (method) {
    case SolverSettings::Method::nsgs:
        return std::make_unique<Nsgs<D>>(sweep);
    case SolverSettings::Method::ansgs:
        return std::make_unique<Ansgs<D>>(sweep);
    case SolverSettings::Method::nncg:
        return std::make_unique<Nncg<D>>(sweep);
    case SolverSettings::Method::apgd:
        return std::make_unique<Apgd<D>>(sweep);
    case SolverSettings::Method::cpg:
        return std::make_unique<Cpg<D>>(sweep);
    case SolverSettings::Method::cundall: // nothing to iterate
        break;
    }
    return nullptr;
}

template std::unique_ptr<Iteration<2>> make_iteration(SolverSettings::Method, TileSweep<2>&);

} // namespace nappe
