#pragma once
// The skeleton of all contact solvers: warm start, so many sweeps or as many as a tolerance on the residual asks for, and
// the residual itself, which is the same for every method (docs/notation.md). What a sweep is belongs to the method
// (iteration.hpp). The order of relaxation is that of tile colours and, in a tile, of contact classes: the same on any
// number of ranks.

#include "solver/iteration.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace nappe {

/// How far from solved, relative to the velocity scale V of docs/notation.md.
struct Residual {
    double largest = 0;
    double rms = 0;
};

/// What a solve did.
struct SolveReport {
    int sweeps = 0;               ///< all that were done, those between a check and its effect included
    bool converged = true;        ///< false only if a tolerance was set and no residual measured was within it
    std::int64_t relaxations = 0; ///< on this rank
    std::int64_t reductions = 0;  ///< that the method waited for; global
};

/// Sweeps from the check of a tolerance to its effect, while ranks agree on the residual behind the sweeps: the
/// reduction of 2^k ranks takes k rounds, and each of the four colours of a sweep lets it advance by one at least, so
/// four sweeps hide it on 65,536 ranks. Never more than from one check to the next. A constant, so that results do not
/// depend on when it arrives. The other methods wait for a sum in every sweep anyway, and their residual does not fall
/// steadily: a check acts at once.
inline int check_lag(const SolverSettings& settings) {
    constexpr int most = 4;
    if (settings.method != SolverSettings::Method::nsgs) {
        return 0;
    }
    return settings.check_every < most ? settings.check_every : most;
}

template <int D>
class ContactSolver {
public:
    /// @param time_tiles whether solve() samples what each tile costs
    ContactSolver(const Communicator& comm, Stopwatch& watch, bool time_tiles = false)
        : comm_(comm), watch_(watch), sweep_(comm, watch), time_tiles_(time_tiles) {}

    /// Local. After a rebuild: which tiles come first.
    /// @param watch_bodies whether tiles may be skipped: then the bodies of each are listed
    void order_tiles(const CandidateSet<D>& candidates, bool watch_bodies = false) {
        sweep_.order_tiles(candidates, watch_bodies);
    }

    /// **Collective.** From free velocities to u = u_free + M⁻¹ H r with the impulses that `contacts` holds.
    void warm_start(ContactsOf<D>& contacts, Halo<D>& halo, std::vector<BodyVelocity<D>>& u);

    /// **Collective.** Sweeps of the settings' method: `sweeps` of them; with a tolerance at least as many, and then, for
    /// the first k that check_every divides and whose residual, measured after sweep k, is within the tolerance, k +
    /// check_lag(settings); max_sweeps at most, and then the residual after the last one says whether it converged.
    /// @param scale V [m/s]; needed only with a tolerance.
    SolveReport solve(ContactsOf<D>& contacts, Halo<D>& halo, std::vector<BodyVelocity<D>>& u,
                      const SolverSettings& settings, int sweeps, double scale);

    /// Local. After order_tiles, before `pass`.
    void find_early(const Halo<D>& halo) { sweep_.find_early(halo); }

    /// **Collective.** One pass of smooth contacts, colour by colour, that opens and closes the grains of tiles as well
    /// (fused_pass.hpp).
    template <class Open, class Press, class Close>
    void pass(Halo<D>& halo, std::vector<BodyVelocity<D>>& u, const Open& open, const Press& press,
              const Close& close) {
        sweep_.pass(halo, u, open, press, close);
    }

    /// **Collective.** n passes of the correction of positions that `contacts` has begun; w are its velocities.
    void correct(ContactsOf<D>& contacts, Halo<D>& halo, std::vector<BodyVelocity<D>>& w, int n);

    /// **Collective.** Sum of term(i) over all grains, i the row on the rank that owns it; the same on any number of ranks.
    template <class Term>
    double sum_over_grains(Term&& term) {
        return sweep_.sum_over_grains(term);
    }

    /// **Collective.** Pre: copies are equal. @param scale V [m/s]; 0: the residual is absolute [m/s].
    Residual residual(const ContactsOf<D>& contacts, const std::vector<BodyVelocity<D>>& u, double scale);

    /// Local. Seconds that each tile took in the first sweep of the last solve; empty unless asked for.
    const std::vector<double>& tile_seconds() const { return tile_seconds_; }

    /// Local. How often each tile was relaxed in the last solve; empty if all were in every sweep. Pre: a solve.
    const std::vector<std::int32_t>& tile_sweeps() const { return iteration_->tile_sweeps(); }

    /// Local. Iteration::bytes_of_bodies. Pre: a solve.
    std::size_t bytes_of_method() const { return iteration_ ? iteration_->bytes_of_bodies() : 0; }

private:
    /// One solve and its limits.
    struct Task {
        ContactProblem<D> problem;
        int least, most; ///< sweeps
    };

    /// The tolerance's checks: after which sweeps one is made.
    static bool is_checked(int sweep, const Task& task);
    static int next_halt(int k, const Task& task);
    bool stops_after(int k, const Task& task);
    double largest_squared(const Task& task);

    const Communicator& comm_;
    Stopwatch& watch_;
    TileSweep<D> sweep_;
    std::optional<SolverSettings::Method> method_; ///< of iteration_
    std::unique_ptr<Iteration<D>> iteration_;
    bool time_tiles_;
    std::vector<double> tile_seconds_;
    PendingMax agreeing_;
};

} // namespace nappe
