#include "solver/simulation.hpp"

#include "core/large_grains.hpp"
#include "core/mix.hpp"

#include <algorithm>
#include <limits>

namespace nappe {

template <int D>
double smallest_radius(const Scene<D>& scene) {
    double r = scene.sample ? scene.sample->radii.min : std::numeric_limits<double>::infinity();
    for (const auto& g : scene.grains) {
        r = std::min(r, g.radius);
    }
    return r;
}

template <int D>
Simulation<D>::Simulation(const Communicator& comm, const Scene<D>& scene, const DiskKernels& kernels)
    : comm_(comm), scene_(scene), walls_(scene.walls),
      domain_(comm, TileGrid<D>(Vec<D>::Zero(), scene.tiles.side_for(largest_radius(scene))), scene.balance),
      contacts_(scene, kernels), solver_(comm, watch_, scene.balance.by == BalanceSettings::By::time),
      sums_(scene.output.cells.size(), walls_, scene.output.gauges), r_max_(largest_radius(scene)),
      r_min_(smallest_radius(scene)) {
    skin_ = scene.tiles.skin_for(r_max_);
    state_.carries = features_of(scene);
    state_.large_above = nappe::large_above(scene);
}

template <int D>
void Simulation<D>::load(const std::vector<GrainRow<D>>& grains, const std::vector<ContactRow<D>>& impulses, double h) {
    impulse_h_ = h;
    const auto lap = watch_.lap(Timed::prepare);
    std::vector<GrainRecord<D>> records;
    records.reserve(grains.size());
    for (const auto& row : grains) {
        records.push_back(to_record(row));
    }
    walls_ = Walls<D>(scene_.walls);
    energy_wanted_ = false;
    stage_start_ = 0;
    stage_steps_ = 0;
    correction_work_ = 0;
    rebuild_due_ = true;
    take(std::move(records), impulses, {});
    place_walls();
}

/// Grains and impulses in place of those that were; nothing that is reported may tell a sample made in this run from one
/// found in the store. @param owners of tiles; none: tiles are cut by their grains
template <int D>
void Simulation<D>::take(std::vector<GrainRecord<D>> records, const std::vector<ContactRow<D>>& impulses,
                         const std::vector<TileOwner>& owners) {
    ExactSum radii, mass;
    for (const auto& g : records) {
        radii.add(g.radius);
        mass.add(g.mass);
    }
    comm_.sum(radii.limbs());
    comm_.sum(mass.limbs());
    const auto n = comm_.sum(static_cast<std::int64_t>(records.size()));
    mean_radius_ = n > 0 ? radii.value() / static_cast<double>(n) : 0.0;
    total_mass_ = mass.value();
    counters_ = {};
    last_balance_ = 0;
    domain_.halo().clear_traffic();
    last_residual_.reset();
    last_sweeps_ = 0;
    domain_.distribute(std::move(records), impulses, walls_.n_bodies(), state_, memory_, owners);
    candidates_ = {};
    memory_is_set_ = true;
    impulses_stale_ = false;
    intact_ = true;
    start_.held = false;
    watcher_.clear();
    contacts_.forget();
    costs_ = {};
    relaxing_ = 0;
}

template <int D>
void Simulation<D>::start_stage(int stage) {
    const bool follows = !scene_.stages[static_cast<std::size_t>(stage)].until && stage > 0 && stage_ == stage - 1 &&
                         !scene_.stages[static_cast<std::size_t>(stage_)].until;
    stage_start_ = follows ? time() : 0.0;
    stage_ = stage;
    stage_steps_ = 0;
    stage_substeps_ = 0;
    drive_walls();
    configure_stage();
    set_margins();
    rebuild();
    rebuild_due_ = false;
    some_fast_ = true; // until a substep has looked
    rescale_impulses(settings().h / settings().substeps);
}

/// What contacts and halo must know of the stage before lists are made for it.
template <int D>
void Simulation<D>::configure_stage() {
    // Samples are prepared without cohesion, so that all strengths of it start from one.
    contacts_.set_cohesive(!scene_.stages[static_cast<std::size_t>(stage_)].until);
    contacts_.set_smooth(smooth());
    contacts_.set_kept(std::min(settings().geometry_every, settings().substeps), settings().position_correction > 0);
    domain_.halo().couple_by_sweep(settings().coupling == SolverSettings::Coupling::sweep);
    state_.attraction = contacts_.cohesive() ? 0.5 * largest_range(scene_) : 0.0;
}

/// A warm start hands on forces: r = f h.
template <int D>
void Simulation<D>::rescale_impulses(double h) {
    if (h != impulse_h_) {
        const double factor = h / impulse_h_;
        for (double& n : candidates_.r_n) {
            n *= factor;
        }
        for (auto& r_t : candidates_.r_t) {
            for (double& t : r_t) {
                t *= factor;
            }
        }
    }
    impulse_h_ = h;
}

template <int D>
void Simulation<D>::mark_cells() {
    for (LocalId i = 0; i < state_.n_held() && state_.carries.cells; ++i) {
        std::uint64_t bits = 0;
        for (std::size_t k = 0; k < scene_.output.cells.size(); ++k) {
            const auto& cell = scene_.output.cells[k];
            if ((state_.x[i] - cell.centre).norm() <= cell.radius) {
                bits |= std::uint64_t{1} << k;
            }
        }
        state_.cells[i] = bits;
    }
    find_reported_tiles();
    energy_wanted_ = scene_.output.measures.energy;
    energy_.clear();
}

template <int D>
std::vector<GrainRow<D>> Simulation<D>::grain_rows() const {
    std::vector<GrainRow<D>> rows;
    rows.reserve(static_cast<std::size_t>(state_.n_own));
    for (LocalId i = 0; i < state_.n_own; ++i) {
        rows.push_back(to_row(state_.record(i)));
    }
    return rows;
}

template <int D>
std::uint64_t Simulation<D>::state_hash() const {
    std::uint64_t sum = 0; // of hashes by name, so that neither order nor owner matters
    for (LocalId i = 0; i < state_.n_own; ++i) {
        std::uint64_t h = mix(static_cast<std::uint64_t>(state_.id[i]));
        for (int d = 0; d < D; ++d) {
            h = mix(h, state_.x[i][d]);
            h = mix(h, state_.u[i].v[d]);
        }
        for (int k = 0; k < n_spin<D>; ++k) {
            h = mix(h, state_.u[i].s[k]);
            h = mix(h, state_.rotation_of(i)[k]);
        }
        sum += mix(h, state_.radius[i]);
    }
    for (const auto& row : contact_rows()) {
        std::uint64_t h = mix(mix(static_cast<std::uint64_t>(row.lo)), static_cast<std::uint64_t>(row.hi));
        h = mix(h, row.r_n);
        for (const double t : row.r_t) {
            h = mix(h, t);
        }
        sum += h;
    }
    return comm_.sum_wrapping(sum);
}

template class Simulation<2>;
template double smallest_radius(const Scene<2>&);

} // namespace nappe
