#include "solver/disk_contacts.hpp"

#include "core/contact_geometry.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <cmath>

namespace nappe {

namespace {

double normal_speed(const Vec<2>& n, const BodyVelocity<2>& a, const BodyVelocity<2>& b) {
    return n[0] * (a.v[0] - b.v[0]) + n[1] * (a.v[1] - b.v[1]);
}

/// Detection positions go from mid - h v to mid from one step to the next.
bool went_through(const State<2>& state, const Walls<2>& walls, const ContactGeometry<2>& g, LocalId a, LocalId b,
                  double h) {
    if (g.through || b < state.n_held()) {
        return g.through;
    }
    const auto& v_a = state.u_old[a].v;
    const auto& v_b = state.u_old[b].v;
    return walls.crossed(b - state.n_held(), state.mid[a].position(), h * Vec<2>(v_a[0] - v_b[0], v_a[1] - v_b[1]));
}

/// A gap that the pair will not close, not even at twice its present speed of approach.
bool sleeps(double gap, double size, double v_free, double v_old, double h) {
    const double slower = v_old < v_free ? v_old : v_free;
    return gap > 0.01 * size + (slower < 0 ? -2 * h * slower : 0.0);
}

/// Whether a or b is in the batch already; walls may be, they are never written.
[[maybe_unused]] bool shares_grain(const DiskBatch& batch, LocalId a, LocalId b, LocalId n_grains) {
    for (int l = 0; l < n_lanes; ++l) {
        for (const std::uint32_t index : {batch.a[l], batch.b[l]}) {
            const auto other = static_cast<LocalId>(index / 4);
            if (other < n_grains && (other == a || other == b)) {
                return true;
            }
        }
    }
    return false;
}

} // namespace

PackFaults DiskContacts::pack(const State<2>& state, CandidateSet<2>& candidates, const Walls<2>& walls, double h,
                              bool activate_all) {
    const Step step{state, candidates, walls, h, kept_ * h, activate_all, arrays(state)};
    PackFaults faults;
    deepest_ = 0;
    // Laws that look at approach velocities have every tile packed anew.
    const bool may_stay = !activate_all && !laws_.features.restitution;
    for (std::size_t t = 0; t < ranges_.size() && !fresh_; ++t) {
        store_tile(t, candidates); // its batches will be needed anyway: who undoes a step finds its impulses there
        if (may_stay && refresh_tile(t, step, faults)) {
            continue;
        }
        n_active_ -= ranges_[t].active;
        if (!pack_tile(t, step, faults)) { // no room: all tiles move, with the impulses they have
            for (auto behind = t + 1; behind < ranges_.size(); ++behind) {
                store_tile(behind, candidates);
            }
            fresh_ = true;
            break;
        }
        n_active_ += ranges_[t].active;
    }
    if (fresh_) {
        pack_all(step, faults);
    }
    std::fill(summed_.begin(), summed_.end(), SearchBatch{});
    return faults;
}

/// All tiles, into an empty storage.
void DiskContacts::pack_all(const Step& step, PackFaults& faults) {
    lay_out(step);
    faults = {};
    for (std::size_t t = 0; t < ranges_.size(); ++t) {
        ranges_[t].begin = static_cast<std::int64_t>(batches_.size());
        pack_tile(t, step, faults);
        n_active_ += ranges_[t].active;
        grow(ranges_[t], spare_batches);
    }
    fresh_ = false;
}

/// Normals and biases of a tile all of whose active contacts have lanes; false: some have none, or too many sleep.
bool DiskContacts::refresh_tile(std::size_t tile, const Step& step, PackFaults& faults) {
    Range& range = ranges_[tile];
    if (10 * range.active < 9 * range.packed || any_wakes(tile, step)) {
        return false;
    }
    const std::int64_t was_active = range.active;
    if (cohesive_) {
        refresh_bonds(range, step);
    }
    const Refreshed refreshed = kernels_->refresh(span(range), step.bodies, step.h, step.look);
    range.active = refreshed.awake;
    deepest_ = refreshed.deepest > deepest_ ? refreshed.deepest : deepest_;
    for (auto w = range.walls_begin; w < range.walls_begin + range.n_walls; ++w) {
        WallPair& pair = walls_[static_cast<std::size_t>(w)];
        const auto found = judge_wall(step, pair.candidate, faults);
        const bool acts = found.decision == Decision::act;
        if (acts && pair.slot < 0) {
            range.active = was_active; // what the caller has counted
            return false;
        }
        pair.asleep = found.decision == Decision::sleep;
        if (pair.slot >= 0) {
            DiskBatch& batch = batches_[static_cast<std::size_t>(pair.slot / n_lanes)];
            const auto l = pair.slot % n_lanes;
            batch.nx[l] = found.n[0];
            batch.ny[l] = found.n[1];
            batch.bias[l] = found.bias;
            keep_gap(pair.slot, found.gap);
            if (!acts) {
                batch.m_eff[l] = batch.r_n[l] = 0;
                set_tangential(pair.slot / n_lanes, l, 0);
                --range.active;
            }
        }
    }
    n_active_ += range.active - was_active;
    return true;
}

/// Packs a tile's active contacts into its batches, the last tile of the storage into as many as it needs; false: there
/// is no room.
bool DiskContacts::pack_tile(std::size_t tile, const Step& step, PackFaults& faults) {
    const auto& of = step.candidates.tiles[tile];
    const std::int32_t n = of.candidates_end - of.candidates_begin;
    measure(nullptr, n, step.candidates, of.candidates_begin, step.bodies);
    Range& range = ranges_[tile];
    range.n = range.active = range.packed = 0;
    range.asleep = 0;
    range.others_are_zero = false;
    filled_.clear();
    first_open_ = 0;
    if (n_packed_ > std::numeric_limits<std::int32_t>::max() / 2) {
        std::fill(last_.begin(), last_.end(), 0);
        n_packed_ = 1;
    }
    auto wall = static_cast<std::size_t>(range.walls_begin);
    for (std::int32_t k = 0; k < n; ++k) {
        const std::int32_t c = of.candidates_begin + k;
        const bool of_wall = step.candidates.b[c] >= step.state.n_held();
        const GapBatch& g = gaps_[static_cast<std::size_t>(k / n_lanes)];
        const int l = k % n_lanes;
        const Found found = of_wall ? judge_wall(step, c, faults)
                                    : judge(step, c, Vec<2>(g.nx[l], g.ny[l]), g.gap[l], g.size[l], g.v[l], g.v_old[l]);
        std::int64_t slot = -1;
        if (!of_wall && g.gap[l] < 0) {
            note_overlap(g.gap[l], step.state.radius[step.candidates.a[c]], step.state.radius[step.candidates.b[c]]);
        }
        if (found.decision == Decision::act) {
            slot = place(range, step, c, found);
            if (slot < 0) {
                return false;
            }
        }
        const bool sleeps = found.decision == Decision::sleep;
        if (of_wall) {
            walls_[wall++] = {c, sleeps, slot};
        } else if (sleeps) {
            asleep_[static_cast<std::size_t>(of.candidates_begin + range.asleep++)] = c;
        }
    }
    n_packed_ += static_cast<std::int32_t>(range.n);
    return true;
}

/// Whether a pair needs no lane until pairs are looked at again. @param near gaps of smooth contacts from which on it does [m]
bool DiskContacts::may_rest(double gap, double size, double v_free, double v_old, double look, double near) const {
    return smooth_ ? gap > near : sleeps(gap, size, v_free, v_old, look);
}

/// Fills gaps_ for n candidates: those in `which`, or those from `from` on.
void DiskContacts::measure(const std::int32_t* which, std::int32_t n, const CandidateSet<2>& candidates,
                           std::int32_t from, const BodyArrays& bodies) {
    const auto n_batches = (static_cast<std::size_t>(n) + n_lanes - 1) / n_lanes;
    if (gaps_.size() < n_batches) {
        gaps_.resize(n_batches);
    }
    kernels_->gaps(which, n, candidates.a.data() + from, candidates.b.data() + from, bodies, gaps_.data());
}

bool DiskContacts::any_wakes(std::size_t tile, const Step& step) {
    const std::int32_t n = ranges_[tile].asleep;
    const std::int32_t* which = asleep_.data() + step.candidates.tiles[tile].candidates_begin;
    measure(which, n, step.candidates, 0, step.bodies);
    for (std::int32_t k = 0; k < n; ++k) {
        const GapBatch& g = gaps_[static_cast<std::size_t>(k / n_lanes)];
        const int l = k % n_lanes;
        if (bonded(step, which[k]) || !may_rest(g.gap[l], g.size[l], g.v[l], g.v_old[l], step.look, near_)) {
            return true;
        }
    }
    return false;
}

DiskContacts::Found DiskContacts::judge(const Step& step, std::int32_t c, const Vec<2>& n, double gap, double size,
                                        double v_free, double v_old) const {
    const LocalId a = step.candidates.a[c], b = step.candidates.b[c];
    Found found{Decision::act, n, gap > 0 ? gap / step.h : 0.0, gap};
    if (laws_.features.restitution && !smooth_) {
        const double e = laws_.restitution(step.state.material[a], step.state.material[b]);
        if (e > 0) {
            // Newton's law needs the approach that free flight brings; a gap bias would take it away a step early.
            if (gap > 0 && gap + step.h * v_free > 0) {
                found.decision = Decision::ignore;
            }
            found.bias = e * (v_old < 0 ? v_old : 0.0);
            return found;
        }
    }
    if (!step.activate_all && !bonded(step, c) && may_rest(gap, size, v_free, v_old, step.look, 2 * near_)) {
        found.decision = Decision::sleep;
    }
    return found;
}

DiskContacts::Found DiskContacts::judge_wall(const Step& step, std::int32_t c, PackFaults& faults) {
    const auto& state = step.state;
    const LocalId a = step.candidates.a[c], b = step.candidates.b[c];
    const auto g = contact_geometry(state, step.walls, a, b);
    if (went_through(state, step.walls, g, a, b, step.h) && state.id[a] < faults.through_wall) {
        faults.through_wall = state.id[a];
        faults.wall = step.walls.feature(b - state.n_held()).wall;
    }
    if (smooth_) { // always a lane: who comes round a corner of walls overlaps from one step to the next
        return {Decision::act, g.n, 0, g.applies ? g.gap : 0.0};
    }
    if (!g.applies) {
        return {};
    }
    note_overlap(g.gap, state.radius[a], state.radius[a]);
    return judge(step, c, g.n, g.gap, state.radius[a] + state.radius[a], normal_speed(g.n, state.u[a], state.u[b]),
                 normal_speed(g.n, state.u_old[a], state.u_old[b]));
}

/// Into the first batch with a free lane behind those of both grains; returns the lane among all lanes, -1: no room.
std::int64_t DiskContacts::place(Range& range, const Step& step, std::int32_t c, const Found& found) {
    const LocalId a = step.candidates.a[c], b = step.candidates.b[c];
    const bool of_wall = b >= step.state.n_held();
    const std::int32_t last_a = last_[static_cast<std::size_t>(a)];
    const std::int32_t last_b = of_wall ? 0 : last_[static_cast<std::size_t>(b)];
    const std::int32_t behind = (last_a > last_b ? last_a : last_b) + 1 - n_packed_;
    auto k = std::max(first_open_, static_cast<std::size_t>(behind > 0 ? behind : 0));
    while (k < filled_.size() && filled_[k] == n_lanes) {
        ++k;
    }
    if (k == filled_.size()) {
        if (range.n == range.room) {
            if (range.begin + range.room < static_cast<std::int64_t>(batches_.size())) {
                return -1;
            }
            grow(range, 1);
        }
        clear(range.begin + range.n, step.state.null_body());
        ++range.n;
        filled_.push_back(0);
    }
    const std::int64_t at = range.begin + static_cast<std::int64_t>(k);
    DiskBatch& batch = batches_[static_cast<std::size_t>(at)];
    const int l = filled_[k]++;
    while (first_open_ < filled_.size() && filled_[first_open_] == n_lanes) {
        ++first_open_;
    }
    NAPPE_ASSERT(!shares_grain(batch, a, b, step.state.n_held()),
                 "a batch holds grain " + std::to_string(step.state.id[a]) + " or its partner twice");
    last_[static_cast<std::size_t>(a)] = n_packed_ + static_cast<std::int32_t>(k);
    if (!of_wall) {
        last_[static_cast<std::size_t>(b)] = n_packed_ + static_cast<std::int32_t>(k);
    }
    batch.nx[l] = found.n[0];
    batch.ny[l] = found.n[1];
    batch.bias[l] = found.bias;
    keep_gap(at * n_lanes + l, found.gap);
    batch.m_eff[l] = 1.0 / (step.state.u[a].inv_m + step.state.u[b].inv_m);
    const auto r = step.candidates.impulse(static_cast<std::size_t>(c));
    batch.r_n[l] = r.n;
    set_tangential(at, l, r.t[0]);
    batch.a[l] = 4u * static_cast<std::uint32_t>(a);
    batch.b[l] = 4u * static_cast<std::uint32_t>(b);
    if (laws_.features.mixed_friction) {
        friction_[static_cast<std::size_t>(at)].mu[l] = laws_.friction(step.state.material[a], step.state.material[b]);
    }
    if (cohesive_) {
        refresh_bond(at * n_lanes + l, step, c);
    }
    if (smooth_) {
        set_springs(at, l, step.state.material[a], step.state.material[b]);
    }
    source_[static_cast<std::size_t>(at * n_lanes + l)] = c;
    ++range.active;
    ++range.packed;
    return at * n_lanes + l;
}

void DiskContacts::set_springs(std::int64_t batch, int l, int material_a, int material_b) {
    const Springs& given = laws_.springs(material_a, material_b);
    const double m = batches_[static_cast<std::size_t>(batch)].m_eff[l];
    const double critical = 2 * std::sqrt(m * given.normal.k);
    SpringBatch& springs = springs_[static_cast<std::size_t>(batch)];
    springs.k_n[l] = given.normal.k;
    springs.k_s[l] = given.tangential.k;
    springs.c_n[l] = given.normal.c.value_or(critical);
    springs.c_s[l] = given.tangential.c.value_or(critical);
    springs.mu[l] = laws_.friction(material_a, material_b);
}

/// missed_any for the contacts of disks that sleep in their lanes.
bool DiskContacts::missed_in_lanes(const Range& range, const State<2>& state, const Walls<2>& walls, double h) const {
    for (auto k = range.begin; k < range.begin + range.n; ++k) {
        const DiskBatch& batch = batches_[static_cast<std::size_t>(k)];
        for (int l = 0; l < n_lanes; ++l) {
            if (batch.m_eff[l] > 0 || source_[static_cast<std::size_t>(k * n_lanes + l)] < 0) {
                continue;
            }
            const LocalId a = row(batch.a[l]), b = row(batch.b[l]);
            if (b >= state.n_held()) {
                continue;
            }
            const auto g = contact_geometry(state, walls, a, b);
            if (g.gap + h * normal_speed(g.n, state.u[a], state.u[b]) < 0) {
                return true;
            }
        }
    }
    return false;
}

bool DiskContacts::missed_any(const State<2>& state, const CandidateSet<2>& candidates, const Walls<2>& walls,
                              double h) {
    for (std::size_t t = 0; t < ranges_.size(); ++t) {
        const std::int32_t n = ranges_[t].asleep;
        measure(asleep_.data() + candidates.tiles[t].candidates_begin, n, candidates, 0, arrays(state));
        for (std::int32_t k = 0; k < n; ++k) {
            const GapBatch& g = gaps_[static_cast<std::size_t>(k / n_lanes)];
            if (g.gap[k % n_lanes] + h * g.v[k % n_lanes] < 0) {
                return true;
            }
        }
        if (ranges_[t].active < ranges_[t].packed && missed_in_lanes(ranges_[t], state, walls, h)) {
            return true;
        }
    }
    return std::any_of(walls_.begin(), walls_.end(), [&](const WallPair& pair) {
        const LocalId a = candidates.a[pair.candidate], b = candidates.b[pair.candidate];
        if (!pair.asleep) {
            return false;
        }
        const auto g = contact_geometry(state, walls, a, b);
        return g.gap + h * normal_speed(g.n, state.u[a], state.u[b]) < 0;
    });
}

} // namespace nappe
