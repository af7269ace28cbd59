#pragma once
// Nanoseconds per relaxation of every kernel that this machine has, and of the list-order reference, on the contacts of
// a simulation between two steps.

#include "commands/bench_loops.hpp"
#include "commands/bench_statistics.hpp"
#include "commands/bench_triad.hpp"
#include "solver/simulation.hpp"

#include <string>
#include <vector>

namespace nappe {

/// **Collective.** The sets of disk_kernels() that the processors of all ranks have, narrowest first.
std::vector<const DiskKernels*> kernels_everywhere(const Communicator& comm);

/// Bytes of memory traffic that a relaxation is charged with, bodies apart: a contact of 56 bytes read, its two
/// impulses written back. Fixed by what the mechanics needs, not by what the code moves: a fatter contact is our loss,
/// not a higher roof.
inline constexpr std::int64_t bytes_per_contact_relaxed = 72;

/// A grain's BodyVelocity read and written once in the sweep of its tile.
inline constexpr std::int64_t bytes_per_grain_swept = 64;

/// The contact problem that the next step of a simulation would have if its contacts were detected where the grains
/// are: packed in the order of tiles, and as a list. Both start with the same impulses, from the same velocities.
/// Local, and so is all it does: the part of this rank, without the exchange.
class SweepProblem {
public:
    /// @param alone a communicator of this rank only; must outlive this
    SweepProblem(const Communicator& alone, const Simulation<2>& simulation);

    /// Sweeps in the order of tiles, as a step does them.
    void sweep(const DiskKernels& kernels, int n);

    /// Sweeps in the order of the list. @param n how many
    void sweep_list(int n);

    std::int64_t n_contacts() const { return contacts_.n_active(); }
    std::int64_t n_slots() const; ///< lanes of all batches, null contacts included
    const DiskContacts& contacts() const { return contacts_; }
    const std::vector<BodyVelocity<2>>& u() const { return u_; }
    const std::vector<ListContact>& list() const { return list_; }
    const std::vector<ListBody>& list_u() const { return list_u_; }
    LocalId list_row(LocalId body) const { return list_row_[static_cast<std::size_t>(body)]; } ///< of a body of State

private:
    void make_list(const Simulation<2>& simulation);

    SolverSettings settings_;
    Stopwatch watch_;
    Halo<2> halo_;
    ContactSolver<2> solver_;
    DiskContacts contacts_;
    std::vector<BodyVelocity<2>> u_;
    double mu_;
    std::vector<ListContact> list_; ///< by (lo id, hi id)
    std::vector<ListBody> list_u_;  ///< grains by id, then the bodies of walls
    std::vector<LocalId> list_row_;
};

/// One kernel at one size; of each round the slowest rank.
struct KernelFigures {
    std::string name;
    int sweeps = 0;            ///< in a round
    Quartiles ns;              ///< per relaxation and rank
    Quartiles times_reference; ///< how many times faster than the list-order reference, round by round
    Quartiles over_fastest;    ///< time over that of the fastest kernel, round by round
    Quartiles over_triad;      ///< time over what the bytes would take at the triad's pace, round by round
};

struct KernelComparison {
    std::int64_t contacts = 0;          ///< of all ranks
    double fill = 0;                    ///< contacts over slots of batches
    TriadFigures triad;                 ///< on as many bytes as a sweep moves
    std::vector<KernelFigures> kernels; ///< the reference first

    const KernelFigures& fastest() const;
    const KernelFigures* find(const std::string& name) const;
};

inline constexpr const char* reference_name = "list order";

struct ComparisonEffort {
    int rounds = 11;
    double seconds = 0.02;      ///< of a kernel's turn, at least
    double triad_seconds = 0.3; ///< of the triad by itself, before the rounds
};

/// **Collective.** Rounds a b c … a b c … of the kernels and the triad, all ranks at once, each on its part.
KernelComparison compare_kernels(const Simulation<2>& simulation, const ComparisonEffort& effort);

} // namespace nappe
