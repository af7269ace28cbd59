#pragma once
// Grains and contacts as plain records: what travels between ranks, into samples and into frames. The arrays that a
// step works on are in core/state.hpp.

#include "core/types.hpp"

#include <array>
#include <cstdint>

namespace nappe {

/// All that makes a grain, at the end of a step. Trivially copyable.
template <int D>
struct GrainRow {
    GlobalId id = 0;
    std::array<double, D> x{};                ///< position [m]
    std::array<double, D> v{};                ///< velocity [m/s]
    std::array<double, n_spin<D>> spin{};     ///< [rad/s]
    std::array<double, n_spin<D>> rotation{}; ///< [rad] since the sample was made
    double radius = 0;                        ///< [m]
    double mass = 0;                          ///< [kg]; in the plane: per metre of depth
    std::uint64_t cells = 0;                  ///< bit k: the grain belongs to Output::cells[k]
    std::int32_t material = 0;
    std::int32_t layer = 0;
};

/// Partners that are walls have keys from here on: wall_key + sided feature (core/walls.hpp).
inline constexpr GlobalId wall_key = GlobalId{1} << 62;

/// The impulses of a contact, named by its two bodies: lo < hi. Trivially copyable.
template <int D>
struct ContactRow {
    GlobalId lo = 0;                 ///< always a grain
    GlobalId hi = 0;                 ///< a grain, or >= wall_key
    double r_n = 0;                  ///< normal impulse of the last step [N s]; < 0 where cohesion pulls
    std::array<double, D - 1> r_t{}; ///< tangential impulse [N s]
};

/// A grain as a frame shows it. Trivially copyable.
template <int D>
struct FrameGrain {
    GrainRow<D> grain;
    double pressure = 0; ///< mean stress of the grain, compression positive [Pa]; in the plane per metre of depth
    std::int32_t coordination = 0; ///< contacts that carry an impulse
    std::int32_t rank = 0;         ///< that owned it
};

/// What a contact did in the last step.
enum class ContactStatus : std::int32_t { open = 0, stick = 1, slip = 2 };

/// How a pair stands by its gap at the end of a step (seeds/000 fig. 3): what decides which law acts in the next one.
enum class Bond : std::int8_t {
    none = 0,     ///< gap > d_w: the plain law
    cohesive = 1, ///< 0 < gap <= d_w
    stick = 2     ///< gap <= 0
};

inline Bond bond_at(double gap, double d_w) {
    return gap > d_w ? Bond::none : gap > 0 ? Bond::cohesive : Bond::stick;
}

/// A contact as a frame shows it: those with an impulse, a gap <= 0 or a bond. Trivially copyable.
template <int D>
struct FrameContact {
    GlobalId lo = 0;
    GlobalId hi = 0;                 ///< a grain, or >= wall_key
    std::array<double, D> point{};   ///< midway between the two surfaces [m]
    std::array<double, D> normal{};  ///< unit, from hi to lo
    double gap = 0;                  ///< [m], negative where the two overlap
    double r_n = 0;                  ///< [N s]; < 0 where cohesion pulls
    std::array<double, D - 1> r_t{}; ///< [N s]
    std::int32_t wall = -1;          ///< index into Scene::walls, -1 between grains
    std::int32_t status = 0;         ///< ContactStatus
    std::int32_t bond = 0;           ///< Bond, by the gap now
};

} // namespace nappe
