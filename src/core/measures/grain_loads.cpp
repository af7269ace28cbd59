#include "core/measures/grain_loads.hpp"

#include <algorithm>

namespace nappe {

namespace {

/// Of a contact, for one of its grains.
template <int D>
double share_of(const ContactSide<D>& side) {
    return side.partner >= wall_key ? 1.0 : 0.5;
}

template <int D>
void add(GrainLoad<D>& load, const ContactSide<D>& side, double radius) {
    const double smaller = radius < side.partner_radius ? radius : side.partner_radius;
    const double overlap = side.gap < 0 ? -side.gap / smaller : 0.0;
    load.largest_overlap = overlap > load.largest_overlap ? overlap : load.largest_overlap;
    const double share = side.carries ? share_of(side) : 0.0;
    load.share += share;
    load.overlap += share * overlap;
    load.contacts += side.carries ? 1 : 0;
    for (int i = 0; i < D; ++i) {
        for (int j = 0; j < D; ++j) {
            load.moment(i, j) += side.r[i] * (radius * side.n[j]);
            load.fabric(i, j) += share * (side.n[i] * side.n[j]);
        }
    }
}

} // namespace

template <int D>
ContactSide<D> side_of_lo(const FrameContact<D>& contact) {
    static_assert(D == 2, "the tangent below is that of the plane");
    ContactSide<D> side;
    side.grain = contact.lo;
    side.partner = contact.hi;
    side.n = contact.normal;
    side.r = {contact.r_n * contact.normal[0] - contact.r_t[0] * contact.normal[1],
              contact.r_n * contact.normal[1] + contact.r_t[0] * contact.normal[0]};
    side.gap = contact.gap;
    side.carries = contact.r_n != 0;
    return side;
}

template <int D>
ContactSide<D> side_of_hi(const FrameContact<D>& contact) {
    ContactSide<D> side = side_of_lo(contact);
    std::swap(side.grain, side.partner);
    for (int d = 0; d < D; ++d) {
        side.n[d] = -side.n[d];
        side.r[d] = -side.r[d];
    }
    return side;
}

template <int D>
std::vector<GrainLoad<D>> grain_loads(std::span<const FrameGrain<D>> grains, std::span<const ContactSide<D>> sides) {
    std::vector<GrainLoad<D>> loads(grains.size());
    auto side = sides.begin();
    for (std::size_t i = 0; i < grains.size(); ++i) {
        for (; side != sides.end() && side->grain == grains[i].grain.id; ++side) {
            add(loads[i], *side, grains[i].grain.radius);
        }
    }
    return loads;
}

template ContactSide<2> side_of_lo(const FrameContact<2>&);
template ContactSide<2> side_of_hi(const FrameContact<2>&);
template std::vector<GrainLoad<2>> grain_loads(std::span<const FrameGrain<2>>, std::span<const ContactSide<2>>);

} // namespace nappe
