// Cohesion: which pairs are bonded, and what that allows their impulses (the non-smooth Lennard-Jones law, seeds/000 §4.3
// in the reading of docs/notation.md). A pair is bonded in a step if its gap at the start of it is d_w or less, whether it
// was so before or not: breaking is no memory, it is distance.

#include "core/contact_geometry.hpp"
#include "solver/disk_contacts.hpp"

namespace nappe {

void DiskContacts::find_bonds(const State<2>& state, CandidateSet<2>& candidates, const Walls<2>& walls) {
    candidates.bond.assign(static_cast<std::size_t>(candidates.size()), Bond::none);
    for (const auto& tile : candidates.tiles) {
        measure(nullptr, tile.candidates_end - tile.candidates_begin, candidates, tile.candidates_begin, arrays(state));
        for (auto c = tile.candidates_begin; c < tile.candidates_end; ++c) {
            const LocalId a = candidates.a[c], b = candidates.b[c];
            const double range = laws_.range(state.material[a], state.material[b]);
            if (!(range > 0)) {
                continue;
            }
            const auto k = c - tile.candidates_begin;
            double gap = gaps_[static_cast<std::size_t>(k / n_lanes)].gap[k % n_lanes];
            if (b >= state.n_held()) {
                const auto g = contact_geometry(state, walls, a, b);
                if (!g.applies) {
                    continue;
                }
                gap = g.gap;
            }
            candidates.bond[static_cast<std::size_t>(c)] = bond_at(gap, range);
        }
    }
}

/// For all lanes of a tile.
void DiskContacts::refresh_bonds(const Range& range, const Step& step) {
    for (auto slot = range.begin * n_lanes; slot < (range.begin + range.n) * n_lanes; ++slot) {
        const std::int32_t c = source_[static_cast<std::size_t>(slot)];
        if (c >= 0) {
            refresh_bond(slot, step, c);
        }
    }
}

/// What attraction a lane's pair may have in this step. One that is no more bonded loses what it had at once.
void DiskContacts::refresh_bond(std::int64_t slot, const Step& step, std::int32_t c) {
    DiskBatch& batch = batches_[static_cast<std::size_t>(slot / n_lanes)];
    const auto l = slot % n_lanes;
    double& most = cohesion_[static_cast<std::size_t>(slot / n_lanes)].most[l];
    if (bonded(step, c)) {
        const auto& material = step.state.material;
        most = step.h * laws_.gamma(material[row(batch.a[l])], material[row(batch.b[l])]);
        return;
    }
    most = 0;
    if (batch.r_n[l] < 0) {
        batch.r_n[l] = 0;
        set_tangential(slot / n_lanes, l, 0);
    }
}

} // namespace nappe
