#include "solver/iteration.hpp"

#include "solver/nsgs.hpp"

namespace nappe {

template <int D>
std::unique_ptr<Iteration<D>> make_iteration(SolverSettings::Method method, TileSweep<D>& sweep) {
    switch (method) {
    case SolverSettings::Method::nsgs:
        return std::make_unique<Nsgs<D>>(sweep);
    }
    return nullptr;
}

template std::unique_ptr<Iteration<2>> make_iteration(SolverSettings::Method, TileSweep<2>&);

} // namespace nappe
