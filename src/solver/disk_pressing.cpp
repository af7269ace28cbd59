// Smooth contacts: who has a lane, and what is done with lanes in a step and after it.

#include "core/contact_geometry.hpp"
#include "solver/disk_contacts.hpp"

#include <algorithm>

namespace nappe {

PackFaults DiskContacts::gather_near(const State<2>& state, CandidateSet<2>& candidates, const Walls<2>& walls,
                                     double h, double near) {
    near_ = near;
    const Step step{state, candidates, walls, h, h, false, arrays(state)};
    PackFaults faults;
    for (std::size_t t = 0; t < ranges_.size() && !fresh_; ++t) {
        const Range& range = ranges_[t];
        if (!any_wakes(t, step)) {
            continue;
        }
        store_tile(t, candidates);
        n_active_ -= range.active;
        if (!pack_tile(t, step, faults)) { // no room: all tiles move, with the springs they have
            for (std::size_t other = 0; other < ranges_.size(); ++other) {
                if (other != t) {
                    store_tile(other, candidates);
                }
            }
            fresh_ = true;
            break;
        }
        n_active_ += range.active;
    }
    if (fresh_) {
        pack_all(step, faults);
    }
    return faults;
}

/// Gaps and normals of a tile's contacts with walls.
void DiskContacts::meet_walls(const Range& range, const Step& step, PackFaults& faults) {
    for (auto w = range.walls_begin; w < range.walls_begin + range.n_walls; ++w) {
        const WallPair& pair = walls_[static_cast<std::size_t>(w)];
        if (pair.slot < 0) {
            continue;
        }
        const std::int64_t k = pair.slot / n_lanes, l = pair.slot % n_lanes;
        DiskBatch& batch = batches_[static_cast<std::size_t>(k)];
        const LocalId a = row(batch.a[l]), b = row(batch.b[l]);
        const auto g = contact_geometry(step.state, step.walls, a, b);
        if (g.through && step.state.id[a] < faults.through_wall) {
            faults.through_wall = step.state.id[a];
            faults.wall = step.walls.feature(b - step.state.n_held()).wall;
        }
        batch.nx[l] = g.n[0];
        batch.ny[l] = g.n[1];
        keep_gap(pair.slot, g.applies ? g.gap : 0.0);
        of_walls_[static_cast<std::size_t>(k - range.begin)] = 1;
    }
}

SmoothTally DiskContacts::press(std::size_t tile, const State<2>& state, const CandidateSet<2>& candidates,
                                const Walls<2>& walls, const SmoothStep& step, PackFaults& faults) {
    const Range& range = ranges_[tile];
    const bool any_wall = range.n_walls > 0;
    if (any_wall) {
        of_walls_.assign(static_cast<std::size_t>(range.n), 0);
        meet_walls(range, Step{state, candidates, walls, step.h, step.h, false, arrays(state)}, faults);
    }
    TangentBatch* const after = tangent_after_.empty() ? nullptr : tangent_after_.data() + range.begin;
    return kernels_->press(span(range), springs_.data() + range.begin, after, any_wall ? of_walls_.data() : nullptr,
                           step);
}

void DiskContacts::record(const State<2>& state, double h) {
    deepest_ = 0;
    for (std::size_t t = 0; t < ranges_.size() && !fresh_; ++t) {
        const Range& range = ranges_[t];
        const double deep = kernels_->record(span(range), springs_.data() + range.begin,
                                             {state.mid.data()->x.data(), doubles(state.u_old)}, h);
        deepest_ = deep > deepest_ ? deep : deepest_;
    }
}

} // namespace nappe
