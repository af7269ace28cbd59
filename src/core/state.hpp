#pragma once
// Everything a rank knows of its grains, in one place: rows [0, n_own) are owned, [n_own, n_held) are copies of grains
// that others own (ghosts), and then come the unmovable bodies of walls, one per sided feature, and one null body that
// pads batches. Ghosts are integrated like owned grains, so that between rebuilds only velocities travel.

#include "core/features.hpp"
#include "core/rows.hpp"
#include "core/types.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace nappe {

/// What the sweep reads and writes of a body, one 256-bit load in the plane. `s` is the speed of the rim, radius x spin
/// [m/s]: with it no lever arm is needed in the kernel. `inv_m` is 1/mass [1/kg], 0 for what does not move.
/// 32 bytes in the plane. (Rejected: separate arrays per component — four cache lines a body instead of half of one.)
/// With Real = float 16 bytes: what a sweep in single precision works on.
template <int D, class Real = double>
struct alignas(4 * sizeof(Real)) BodyVelocity {
    std::array<Real, D> v{};
    std::array<Real, n_spin<D>> s{};
    Real inv_m = 0;
};

/// Where a body stands when contacts are detected, and its radius: one 256-bit load in the plane. Bodies of walls have
/// the radius NaN, so that no arithmetic on disks finds them near anything: walls have their own.
template <int D>
struct alignas(32) BodyPlace {
    std::array<double, D> x{}; ///< [m]
    double radius = 0;         ///< [m]
    double rotation = 0;       ///< as a step of smooth contacts begins; nothing elsewhere [rad]

    Vec<D> position() const {
        Vec<D> v;
        for (int d = 0; d < D; ++d) {
            v[d] = x[d];
        }
        return v;
    }
};

/// A grain as it travels between ranks, bit for bit. Trivially copyable.
template <int D>
struct GrainRecord {
    GlobalId id = 0;
    BodyVelocity<D> u;
    std::array<double, D> x{};
    std::array<double, n_spin<D>> rotation{};
    double radius = 0;
    double mass = 0;
    double margin = 0;
    std::uint64_t cells = 0;
    std::int32_t material = 0;
    std::int32_t layer = 0;
};

/// Arrays over bodies; all grain arrays have n_held() rows, `mid`, `u`, `u_old` and `material` have n_bodies(). Those of
/// features that the scene does not have stay empty.
template <int D>
struct State {
    Features carries; ///< to be set before the first grains come
    LocalId n_own = 0;
    double attraction = 0; ///< half the largest gap at which cohesion acts in this stage [m]
    double large_above = std::numeric_limits<double>::infinity(); ///< radius beyond which a grain is large [m]
    std::vector<GlobalId> id;
    std::vector<Vec<D>> x;              ///< position at the start of the step [m]
    std::vector<BodyPlace<D>> mid;      ///< predicted position, where contacts are detected
    std::vector<Vec<D>> x_ref;          ///< position at the last rebuild [m]
    std::vector<double> margin;         ///< how far a grain may go from x_ref before the lists are rebuilt [m]
    std::vector<BodyVelocity<D>> u;     ///< velocity, being solved for
    std::vector<BodyVelocity<D>> u_old; ///< velocity at the start of the step
    std::vector<std::array<double, n_spin<D>>> rotation; ///< [rad]; empty where nothing turns
    std::vector<double> radius;                          ///< [m]
    std::vector<double> mass;                            ///< [kg]
    std::vector<std::uint64_t> cells;                    ///< bit k: member of Output::cells[k]; empty without cells
    std::vector<std::int32_t> layer;                     ///< empty where all are 1
    std::vector<std::int32_t> material;

    /// Calls f(name, array) for every array.
    template <class F>
    void for_each_array(F&& f) const {
        f("id", id);
        f("x", x);
        f("mid", mid);
        f("x_ref", x_ref);
        f("margin", margin);
        f("u", u);
        f("u_old", u_old);
        f("rotation", rotation);
        f("radius", radius);
        f("mass", mass);
        f("cells", cells);
        f("layer", layer);
        f("material", material);
    }

    std::array<double, n_spin<D>> rotation_of(LocalId i) const {
        return carries.turning ? rotation[i] : std::array<double, n_spin<D>>{};
    }
    std::uint64_t cells_of(LocalId i) const { return carries.cells ? cells[i] : 0; }
    std::int32_t layer_of(LocalId i) const { return carries.layers ? layer[i] : 1; }

    /// How far from x_ref a grain's contacts may begin before the next rebuild [m].
    double reach(LocalId i) const { return radius[i] + margin[i] + attraction; }

    /// Whether tiles are not made for it (core/large_grains.hpp).
    bool is_large(LocalId i) const { return radius[i] > large_above; }

    LocalId n_held() const { return static_cast<LocalId>(id.size()); }
    LocalId n_bodies() const { return static_cast<LocalId>(u.size()); }
    LocalId null_body() const { return n_bodies() - 1; }

    GrainRecord<D> record(LocalId i) const {
        GrainRecord<D> g;
        g.id = id[i];
        g.u = u[i];
        for (int d = 0; d < D; ++d) {
            g.x[d] = x[i][d];
        }
        g.rotation = rotation_of(i);
        g.radius = radius[i];
        g.mass = mass[i];
        g.margin = margin[i];
        g.cells = cells_of(i);
        g.material = material[i];
        g.layer = layer_of(i);
        return g;
    }

    /// Local. Owned row i becomes what was row from[i], or arrivals[-1 - from[i]] where that is negative; all other rows
    /// go. To be followed by `complete`.
    void reorder(const std::vector<LocalId>& from, const std::vector<GrainRecord<D>>& arrivals);

    /// Local. Behind the owned rows: ghosts, `n_walls` wall bodies and the null body. Positions of all are now those of
    /// the last rebuild.
    void complete(const std::vector<GrainRecord<D>>& ghosts, LocalId n_walls);

    /// Local. Takes owned grains, then ghosts, then room for `n_walls` wall bodies and the null body.
    void assign(const std::vector<GrainRecord<D>>& own, const std::vector<GrainRecord<D>>& ghosts, LocalId n_walls);
};

/// The kinetic energy of a disk (I = m r²/2) in [J]. In space a sphere (2/5 m r²) would take its own factor.
template <int D>
double kinetic_energy(const BodyVelocity<D>& u, double mass) {
    static_assert(D == 2, "the inertia below is a disk's");
    const double v2 = u.v[0] * u.v[0] + u.v[1] * u.v[1];
    return 0.5 * mass * (v2 + 0.5 * u.s[0] * u.s[0]);
}

template <int D>
GrainRecord<D> to_record(const GrainRow<D>& row);

template <int D>
GrainRow<D> to_row(const GrainRecord<D>& record);

} // namespace nappe
