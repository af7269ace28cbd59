#pragma once
// Block non-smooth Gauss–Seidel (seeds/000 eq. 5) by tiles: one sweep relaxes, colour by colour, first the tiles whose
// grains other ranks hold, sends what they changed, relaxes the rest meanwhile, receives. The order of relaxation is
// that of tile colours and, in a tile, of contact classes: the same on any number of ranks. (Departs from the source in
// that order only.)

#include "core/stopwatch.hpp"
#include "parallel/domain.hpp"
#include "solver/disk_contacts.hpp"

#include <array>
#include <vector>

namespace nappe {

/// How far from solved, relative to the velocity scale V of docs/notation.md.
struct Residual {
    double largest = 0;
    double rms = 0;
};

/// What a solve did.
struct SolveReport {
    int sweeps = 0;
    bool converged = true;        ///< false only if a tolerance was set and not reached within max_sweeps
    std::int64_t relaxations = 0; ///< on this rank
};

/// The packed contacts of a dimension and shape: disks in the plane.
template <int D>
struct ContactKind;
template <>
struct ContactKind<2> {
    using Contacts = DiskContacts;
};
template <int D>
using ContactsOf = typename ContactKind<D>::Contacts;

template <int D>
class Nsgs {
public:
    Nsgs(const Communicator& comm, Stopwatch& watch) : comm_(comm), watch_(watch) {}

    /// Local. After a rebuild: which tiles come first.
    void order_tiles(const CandidateSet<D>& candidates);

    /// **Collective.** From free velocities to u = u_free + M⁻¹ H r with the impulses that `contacts` holds.
    void warm_start(const ContactsOf<D>& contacts, Halo<D>& halo, std::vector<BodyVelocity<D>>& u);

    /// **Collective.** Sweeps as the settings say. @param scale V [m/s]; needed only with a tolerance.
    SolveReport solve(ContactsOf<D>& contacts, Halo<D>& halo, std::vector<BodyVelocity<D>>& u,
                      const SolverSettings& settings, int sweeps, double scale);

    /// **Collective.** Pre: copies are equal. @param scale V [m/s]; 0: the residual is absolute [m/s].
    Residual residual(const ContactsOf<D>& contacts, const std::vector<BodyVelocity<D>>& u, double scale);

private:
    template <class Relax>
    void pass(Halo<D>& halo, std::vector<BodyVelocity<D>>& u, Relax&& relax);

    const Communicator& comm_;
    Stopwatch& watch_;
    std::array<std::vector<std::int32_t>, n_tile_colours<D>> interface_, interior_;
};

} // namespace nappe
