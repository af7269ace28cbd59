#include "commands/grain_figures.hpp"

#include "core/measures/backbone.hpp"
#include "core/measures/local_fraction.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace nappe {

namespace {

template <class T>
using ByRank = std::vector<std::vector<T>>;

template <class T>
ByRank<T> by_rank(const Communicator& comm) {
    return ByRank<T>(static_cast<std::size_t>(comm.size()));
}

/// Both sides of every contact, each where its grain is, sorted by (grain, partner). Collective.
std::vector<ContactSide<2>> contact_sides(const Communicator& comm, const FrameBlock<2>& frame) {
    const auto& blocks = frame.blocks;
    const GlobalId first = blocks.first(comm.rank());
    const auto radius = [&](GlobalId id) { return frame.grains[static_cast<std::size_t>(id - first)].grain.radius; };
    auto to = by_rank<ContactSide<2>>(comm);
    for (const auto& contact : frame.contacts) {
        if (contact.hi < wall_key) {
            auto& side = to[static_cast<std::size_t>(blocks.holder(contact.hi))].emplace_back(side_of_hi(contact));
            side.partner_radius = radius(contact.lo);
        }
    }
    const auto arrived = comm.exchange(to);
    // The radii of `hi` go back in the order in which their contacts came.
    auto back = by_rank<double>(comm);
    std::vector<ContactSide<2>> sides;
    for (std::size_t r = 0; r < arrived.size(); ++r) {
        for (const auto& side : arrived[r]) {
            back[r].push_back(radius(side.grain));
        }
        sides.insert(sides.end(), arrived[r].begin(), arrived[r].end());
    }
    const auto radii = comm.exchange(back);
    std::vector<std::size_t> next(radii.size(), 0);
    for (const auto& contact : frame.contacts) {
        auto& side = sides.emplace_back(side_of_lo(contact));
        if (contact.hi < wall_key) {
            const auto holder = static_cast<std::size_t>(blocks.holder(contact.hi));
            side.partner_radius = radii[holder][next[holder]++];
        }
    }
    std::sort(sides.begin(), sides.end(), [](const auto& a, const auto& b) {
        return a.grain != b.grain ? a.grain < b.grain : a.partner < b.partner;
    });
    return sides;
}

/// Takes rattlers away until no rank has any. Collective.
Backbone find_backbone(const Communicator& comm, const IdBlocks& blocks, std::span<const ContactSide<2>> sides) {
    const int r = comm.rank();
    Backbone backbone(blocks.first(r), static_cast<std::size_t>(blocks.count(r)), sides);
    for (std::int64_t told = 1; told > 0;) {
        auto to = by_rank<GlobalId>(comm);
        told = 0;
        for (const GlobalId grain : backbone.take_rattlers()) {
            to[static_cast<std::size_t>(blocks.holder(grain))].push_back(grain);
            ++told;
        }
        told = comm.sum(told);
        for (const auto& part : told > 0 ? comm.exchange(to) : ByRank<GlobalId>{}) {
            for (const GlobalId grain : part) {
                backbone.lose_contact(grain);
            }
        }
    }
    return backbone;
}

/// Columns of the plane as wide as the kernel reaches are dealt out to ranks in turn; a rank that has a column gets the
/// grains beside it too. (Rejected: every grain on every rank, whose memory grows with the sample.) Collective.
std::vector<double> solid_fractions(const Communicator& comm, const FrameBlock<2>& frame, double range) {
    const auto n = static_cast<std::int64_t>(comm.size());
    const auto holder = [n](std::int64_t column) { return ((column % n) + n) % n; };
    auto to = by_rank<FieldGrain>(comm);
    for (const auto& row : frame.grains) {
        const auto& g = row.grain;
        const auto column = static_cast<std::int64_t>(std::floor(g.x[0] / range));
        const auto own = holder(column);
        for (const auto r : std::set{own, holder(column - 1), holder(column + 1)}) {
            to[static_cast<std::size_t>(r)].push_back({g.id, g.x[0], g.x[1], g.radius, r == own});
        }
    }
    std::vector<FieldGrain> grains; // ascending ids, as blocks and what ranks send are
    std::vector<std::size_t> sent;
    for (const auto& part : comm.exchange(to)) {
        grains.insert(grains.end(), part.begin(), part.end());
        sent.push_back(static_cast<std::size_t>(
            std::count_if(part.begin(), part.end(), [](const auto& grain) { return grain.is_target; })));
    }
    const auto found = local_solid_fractions(grains, range);
    auto back = by_rank<double>(comm);
    auto from = found.begin();
    for (std::size_t r = 0; r < sent.size(); ++r) {
        const auto end = from + static_cast<std::ptrdiff_t>(sent[r]);
        back[r].assign(from, end);
        from = end;
    }
    const auto answers = comm.exchange(back);
    std::vector<std::size_t> next(answers.size(), 0);
    std::vector<double> fractions;
    for (const auto& row : frame.grains) {
        const auto r = static_cast<std::size_t>(holder(static_cast<std::int64_t>(std::floor(row.grain.x[0] / range))));
        fractions.push_back(answers[r][next[r]++]);
    }
    return fractions;
}

} // namespace

std::vector<GrainFigures> grain_figures(const Communicator& comm, const FrameBlock<2>& frame, double range) {
    const auto sides = contact_sides(comm, frame);
    const auto loads = grain_loads<2>(frame.grains, sides);
    const auto backbone = find_backbone(comm, frame.blocks, sides);
    const auto fractions = solid_fractions(comm, frame, range);
    std::vector<GrainFigures> figures(frame.grains.size());
    for (std::size_t i = 0; i < figures.size(); ++i) {
        figures[i] = {loads[i], backbone.is_rattler(i), backbone.contacts(i), fractions[i]};
    }
    return figures;
}

} // namespace nappe
