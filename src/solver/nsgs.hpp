#pragma once
// Block non-smooth Gauss–Seidel (seeds/000 eq. 5), by tiles; departs from the source in the order of relaxation only.

#include "solver/iteration.hpp"

namespace nappe {

template <int D>
class Nsgs : public Iteration<D> {
public:
    explicit Nsgs(TileSweep<D>& sweep) : sweep_(sweep) {}
    void begin(const ContactProblem<D>& problem) override;
    IterationWork advance(const ContactProblem<D>& problem, int n) override;

private:
    TileSweep<D>& sweep_;
    int together_ = 1; ///< sweeps that pass over the sample together
};

} // namespace nappe
