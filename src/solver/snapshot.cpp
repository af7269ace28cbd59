// From a running scene to all that the next step depends on, and back (core/snapshot.hpp).
//
// Lists are functions of where things stood at the last rebuild. So a scene is taken up again from there: grains are spread
// and their neighbours found at x_ref, with the margins they had, and only then everything goes to where it is now.

#include "solver/simulation.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

namespace nappe {

namespace {

template <int D>
std::array<double, D> array_of(const Vec<D>& v) {
    std::array<double, D> a;
    for (int d = 0; d < D; ++d) {
        a[static_cast<std::size_t>(d)] = v[d];
    }
    return a;
}

template <int D>
Vec<D> vector_of(const std::array<double, D>& a) {
    Vec<D> v;
    for (int d = 0; d < D; ++d) {
        v[d] = a[static_cast<std::size_t>(d)];
    }
    return v;
}

template <int D>
SnapshotGrain<D> grain_of(const State<D>& state, LocalId i) {
    SnapshotGrain<D> g;
    g.id = state.id[i];
    g.x = array_of<D>(state.x[i]);
    g.x_ref = array_of<D>(state.x_ref[i]);
    g.v = state.u[i].v;
    g.s = state.u[i].s;
    g.rotation = state.rotation_of(i);
    g.radius = state.radius[i];
    g.mass = state.mass[i];
    g.margin = state.margin[i];
    g.cells = state.cells_of(i);
    g.material = state.material[i];
    g.layer = state.layer_of(i);
    return g;
}

/// As it was at the last rebuild, but with the velocity of now.
template <int D>
GrainRecord<D> record_of(const SnapshotGrain<D>& grain) {
    GrainRecord<D> g;
    g.id = grain.id;
    g.u.v = grain.v;
    g.u.s = grain.s;
    g.u.inv_m = 1 / grain.mass;
    g.x = grain.x_ref;
    g.rotation = grain.rotation;
    g.radius = grain.radius;
    g.mass = grain.mass;
    g.margin = grain.margin;
    g.cells = grain.cells;
    g.material = grain.material;
    g.layer = grain.layer;
    return g;
}

} // namespace

template <int D>
SnapshotClock Simulation<D>::clock() const {
    SnapshotClock clock;
    clock.stage = stage_;
    clock.stage_steps = stage_steps_;
    clock.stage_substeps = stage_substeps_;
    clock.rebuild_due = rebuild_due_ ? 1 : 0;
    clock.some_fast = some_fast_ ? 1 : 0;
    clock.energy_wanted = energy_wanted_ ? 1 : 0;
    clock.summed_steps = sums_.n_steps();
    clock.last_balance = last_balance_;
    clock.steps = counters_.steps;
    clock.sweeps = counters_.sweeps;
    clock.rebuilds = counters_.rebuilds;
    clock.redone_lists = counters_.redone_lists;
    clock.redone_groups = counters_.redone_groups;
    clock.redone_packs = counters_.redone_packs;
    clock.reductions = counters_.reductions;
    clock.unconverged = counters_.unconverged;
    clock.rebalanced = counters_.rebalanced;
    const auto& watched = watcher_.memory();
    clock.watched = watched.steps;
    clock.unconverged_in_row = watched.unconverged_in_row;
    clock.divided_steps = watched.divided_steps;
    clock.most_substeps = watched.most_substeps;
    clock.largest_growth = watched.largest_growth;
    clock.largest_scale = watched.largest_scale;
    clock.stage_start = stage_start_;
    clock.impulse_h = impulse_h_;
    clock.correction_work = correction_work_;
    return clock;
}

template <int D>
void Simulation<D>::set_clock(const SnapshotClock& clock) {
    counters_ = {};
    counters_.steps = clock.steps;
    counters_.sweeps = clock.sweeps;
    counters_.rebuilds = clock.rebuilds;
    counters_.redone_lists = clock.redone_lists;
    counters_.redone_groups = clock.redone_groups;
    counters_.redone_packs = clock.redone_packs;
    counters_.reductions = clock.reductions;
    counters_.unconverged = clock.unconverged;
    counters_.rebalanced = clock.rebalanced;
    watcher_.set_memory({clock.watched, clock.unconverged_in_row, clock.divided_steps, clock.most_substeps,
                         clock.largest_growth, clock.largest_scale});
    stage_start_ = clock.stage_start;
    stage_steps_ = clock.stage_steps;
    stage_substeps_ = clock.stage_substeps;
    rebuild_due_ = clock.rebuild_due != 0;
    some_fast_ = clock.some_fast != 0;
    last_balance_ = clock.last_balance;
    correction_work_ = clock.correction_work;
    impulse_h_ = clock.impulse_h;
}

template <int D>
Snapshot<D> Simulation<D>::snapshot() const {
    return snapshot_with(candidates(), sums_, energy_);
}

/// With these impulses and sums.
template <int D>
Snapshot<D> Simulation<D>::snapshot_with(const CandidateSet<D>& candidates, ContactSums<D> sums,
                                         EnergySums<D> energy) const {
    Snapshot<D> s;
    s.clock = clock();
    s.grains.reserve(static_cast<std::size_t>(state_.n_own));
    for (LocalId i = 0; i < state_.n_own; ++i) {
        s.grains.push_back(grain_of(state_, i));
    }
    s.impulses = impulse_rows(state_, candidates);
    for (std::size_t w = 0; w < walls_.offset.size(); ++w) {
        s.walls.push_back({array_of<D>(walls_.offset[w]), array_of<D>(walls_.offset_ref[w]), array_of<D>(walls_.v[w]),
                           array_of<D>(walls_.v_old[w]), walls_.margin[w]});
    }
    const auto keep = [&](ExactSum& sum) { s.sums.insert(s.sums.end(), sum.limbs().begin(), sum.limbs().end()); };
    sums.for_each_sum(keep);
    sums.gauges().for_each_sum(keep);
    energy.for_each_sum(keep);
    comm_.sum(s.sums);
    if (couples_by_sweep(scene_)) {
        s.owners = domain_.directory().owners();
    }
    return s;
}

template <int D>
void Simulation<D>::resume(const Snapshot<D>& from) {
    const auto lap = watch_.lap(Timed::prepare);
    stage_ = static_cast<int>(from.clock.stage);
    configure_stage();
    walls_ = Walls<D>(scene_.walls);
    for (std::size_t w = 0; w < walls_.offset.size(); ++w) {
        const auto& wall = from.walls[w];
        walls_.offset[w] = walls_.offset_mid[w] = walls_.offset_ref[w] = vector_of<D>(wall.offset_ref);
        walls_.v[w] = vector_of<D>(wall.v);
        walls_.v_old[w] = vector_of<D>(wall.v_old);
        walls_.margin[w] = wall.margin;
    }
    std::vector<GrainRecord<D>> records;
    std::vector<PlacedGrain<D>> places;
    records.reserve(from.grains.size());
    places.reserve(from.grains.size());
    for (const auto& grain : from.grains) {
        records.push_back(record_of(grain));
        places.push_back({grain.id, grain.x});
    }
    take(std::move(records), from.impulses, from.owners);
    relist();

    domain_.place(places, state_);
    for (std::size_t w = 0; w < walls_.offset.size(); ++w) {
        walls_.offset[w] = walls_.offset_mid[w] = vector_of<D>(from.walls[w].offset);
    }
    place_walls();

    set_clock(from.clock);
    take_sums(from);
    rescale_impulses(settings().h / settings().substeps);
}

/// Sums of the interval in hand: the root takes those of all ranks.
template <int D>
void Simulation<D>::take_sums(const Snapshot<D>& from) {
    sums_.clear();
    sums_.gauges().for_each_sum([](ExactSum& sum) { sum.clear(); });
    energy_.clear();
    energy_wanted_ = from.clock.energy_wanted != 0;
    sums_.end_steps(static_cast<int>(from.clock.summed_steps));
    auto next = from.sums.begin();
    const auto fill = [&](ExactSum& sum) {
        for (auto& limb : sum.limbs()) {
            if (next != from.sums.end()) {
                limb = comm_.is_root() ? *next : 0;
                ++next;
            }
        }
    };
    sums_.for_each_sum(fill);
    sums_.gauges().for_each_sum(fill);
    energy_.for_each_sum(fill);
}

template SnapshotClock Simulation<2>::clock() const;
template void Simulation<2>::set_clock(const SnapshotClock&);
template Snapshot<2> Simulation<2>::snapshot() const;
template Snapshot<2> Simulation<2>::snapshot_with(const CandidateSet<2>&, ContactSums<2>, EnergySums<2>) const;
template void Simulation<2>::resume(const Snapshot<2>&);
template void Simulation<2>::take_sums(const Snapshot<2>&);

} // namespace nappe
