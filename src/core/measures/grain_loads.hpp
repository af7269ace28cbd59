#pragma once
// What contacts do to each grain of a frame: the terms that stress, fabric, coordination and overlap of a set of grains
// are sums of (docs/measures.md). Everything here is Local.

#include "core/rows.hpp"

#include <limits>
#include <span>
#include <vector>

namespace nappe {

template <int D>
using Tensor = Eigen::Matrix<double, D, D, Eigen::DontAlign>;

/// A contact as one of its two bodies, a grain, sees it. Trivially copyable.
template <int D>
struct ContactSide {
    GlobalId grain = 0;
    GlobalId partner = 0;                                            ///< a grain, or >= wall_key
    std::array<double, D> n{};                                       ///< unit, from the partner to the grain
    std::array<double, D> r{};                                       ///< impulse on the grain [N s]
    double gap = 0;                                                  ///< [m]
    double partner_radius = std::numeric_limits<double>::infinity(); ///< [m]; of a wall infinite
    bool carries = false;                                            ///< an impulse: r_n != 0
};

/// The two sides of a contact; partner_radius is left to whoever knows it. The second has no meaning if `hi` is a wall.
template <int D>
ContactSide<D> side_of_lo(const FrameContact<D>& contact);
template <int D>
ContactSide<D> side_of_hi(const FrameContact<D>& contact);

/// Sums over the contacts of one grain. A contact between two grains counts half for each of them, one with a wall
/// wholly, so that these are additive: over all grains they give the sums over all contacts.
template <int D>
struct GrainLoad {
    /// Sum of r ⊗ (x_i − x_c), the arm x_i − x_c being radius × n as in the dynamics (core/contact_sums.hpp);
    /// compression positive [N m s].
    Tensor<D> moment = Tensor<D>::Zero();
    Tensor<D> fabric = Tensor<D>::Zero(); ///< of n ⊗ n over contacts that carry an impulse, by their share
    double share = 0;                     ///< of contacts that carry an impulse: halves and wholes
    double overlap = 0;         ///< of max(−gap, 0) over the smaller radius, over the same contacts by their share
    double largest_overlap = 0; ///< of all contacts, over the smaller radius
    std::int32_t contacts = 0;  ///< that carry an impulse, each counted whole
};

/// One load a grain, summed in the order of partners' keys. Pre: sides are sorted by (grain, partner), and all of these
/// grains, whose ids ascend.
template <int D>
std::vector<GrainLoad<D>> grain_loads(std::span<const FrameGrain<D>> grains, std::span<const ContactSide<D>> sides);

} // namespace nappe
