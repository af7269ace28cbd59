#pragma once
// What the methods have in common: each makes the impulses of a step better, sweep by sweep, and leaves it to
// ContactSolver when to stop.

#include "solver/tile_sweep.hpp"

#include <cstdint>
#include <memory>
#include <vector>

namespace nappe {

/// One step's contacts: impulses in `contacts`, and u = u_free + M⁻¹ H r, copies equal on all ranks.
template <int D>
struct ContactProblem {
    ContactsOf<D>& contacts;
    Halo<D>& halo;
    std::vector<BodyVelocity<D>>& u;
    const SolverSettings& settings;
    double unit = 1; ///< what residuals are relative to: V, or 1 [m/s]
};

/// What an iteration did.
struct IterationWork {
    std::int64_t relaxations = 0; ///< contacts passed over, on this rank
    std::int64_t reductions = 0;  ///< sums over all ranks that it waited for; global
};

template <int D>
class Iteration {
public:
    virtual ~Iteration() = default;

    /// **Collective.** A new problem; nothing is remembered of the one before.
    virtual void begin(const ContactProblem<D>& problem) = 0;

    /// **Collective.** n more sweeps. After `settle`, impulses are feasible and u belongs to them.
    virtual IterationWork advance(const ContactProblem<D>& problem, int n) = 0;

    /// **Collective.** Called before anyone looks at impulses or u.
    virtual void settle(const ContactProblem<D>&) {}

    /// Local. Bytes that it keeps of bodies beside u: Field::where "Iteration" (fields.hpp).
    virtual std::size_t bytes_of_bodies() const = 0;

    /// Local. How often each tile was relaxed since `begin`; empty if all were in every sweep.
    virtual const std::vector<std::int32_t>& tile_sweeps() const {
        static const std::vector<std::int32_t> all;
        return all;
    }
};

/// The iteration of a method. `sweep` must outlive it.
template <int D>
std::unique_ptr<Iteration<D>> make_iteration(SolverSettings::Method method, TileSweep<D>& sweep);

} // namespace nappe
