#pragma once
// Block non-smooth Gauss–Seidel (seeds/000 eq. 5), by tiles; departs from the source in the order of relaxation only.
//
// With SolverSettings::adaptive a tile is left alone once it is quiet: its last pass changed no contact by more than
// adaptive x V (measured as the residual is), until some grain that its contacts move has changed its velocity by more than
// that since. Whether it is left alone follows from velocities that all holders have alike, so it is the same on any number
// of ranks; nothing is remembered beyond the solve. What is left undone is at most of the size of adaptive x V a contact.
//
// With Precision::single sweeps go over rounded copies of contacts and velocities. `settle` takes the impulses back and makes
// u of them in double, u += M⁻¹ H (r_new - r_old): whatever was rounded, u and the impulses belong together, so that
// momentum and the energy budget close as they do in double.

#include "solver/iteration.hpp"

namespace nappe {

template <int D>
class Nsgs : public Iteration<D> {
public:
    explicit Nsgs(TileSweep<D>& sweep) : sweep_(sweep) {}
    void begin(const ContactProblem<D>& problem) override;
    IterationWork advance(const ContactProblem<D>& problem, int n) override;
    void settle(const ContactProblem<D>& problem) override;
    std::size_t bytes_of_bodies() const override;
    const std::vector<std::int32_t>& tile_sweeps() const override { return tile_sweeps_; }

private:
    bool undisturbed(std::size_t tile) const;
    bool stays_quiet(std::size_t tile, const std::vector<BodyVelocity<D>>& u, double limit_squared) const;
    void note(std::size_t tile, const std::vector<BodyVelocity<D>>& u);
    void round_off(const ContactProblem<D>& problem);

    TileSweep<D>& sweep_;
    int together_ = 1; ///< sweeps that pass over the sample together

    std::vector<BodyVelocity<D, float>> u_single_; ///< empty unless in single precision
    bool rounded_ = false;                         ///< copies are ahead of impulses and u
    // Empty unless adaptive:
    std::vector<std::int32_t> tile_sweeps_;
    std::vector<std::vector<BodyVelocity<D>>> quiet_at_; ///< velocities of a quiet tile's bodies when it became so
    // A clock that counts visits of tiles, to tell whether anything can have changed since a look:
    std::int64_t clock_ = 0;
    std::vector<std::int64_t> relaxed_at_, looked_at_;
};

} // namespace nappe
