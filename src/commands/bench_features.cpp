#include "commands/bench_features.hpp"

#include "solver/fields.hpp"

#include <array>
#include <functional>
#include <memory>

namespace nappe {

namespace {

using Change = std::function<void(Scene<2>&)>;

struct Feature {
    const char* name;
    SettledBlock FeatureBlocks::*block;
    Change without, with; ///< made to the bench's scene, which has one friction coefficient
};

void take_friction(Scene<2>& scene) {
    for (auto& law : scene.laws) {
        law.friction = 0;
    }
}

/// Asks for rotations; the sample, which has its own grains, does not get this one.
void give_spin(Scene<2>& scene) {
    take_friction(scene);
    SingleGrain<2> grain;
    grain.radius = scene.sample->radii.min;
    grain.spin[0] = 1;
    scene.grains.push_back(grain);
}

void mix_friction(Scene<2>& scene) {
    scene.materials.push_back({"side walls", 0.0});
    scene.laws.push_back({0, 1, 0.3, 0.0});
    scene.walls[1].material = scene.walls[2].material = 1;
}

void attract(Scene<2>& scene) {
    scene.laws[0].gamma = 1e4; // [N] as jobs/fault.toml
    scene.laws[0].d_w = 0.01;
}

void bounce(Scene<2>& scene) {
    scene.laws[0].restitution = 0.5;
}

void drive(Scene<2>& scene) {
    scene.walls[1].motion = Motion<2>{{0.5, 0}, 0, 0, {}}; // as jobs/fold.toml
}

/// One cell over the middle third of the bed's height.
void mark(Scene<2>& scene) {
    const auto& profile = scene.sample->profile;
    const double height = profile[2][1];
    scene.output.cells.push_back({"middle", Vec<2>(profile[2][0] / 2, height / 2), height / 6});
}

void layer(Scene<2>& scene) {
    scene.sample->layer_tops = {scene.sample->profile[2][1] / 2};
}

const std::array<Feature, 8>& features() {
    static const auto nothing = [](Scene<2>&) {};
    constexpr auto rough = &FeatureBlocks::rough, smooth = &FeatureBlocks::smooth;
    static const std::array<Feature, 8> all = {{{"friction", smooth, take_friction, nothing},
                                                {"spin without friction", smooth, take_friction, give_spin},
                                                {"friction by pair", rough, nothing, mix_friction},
                                                {"cohesion", rough, nothing, attract},
                                                {"restitution", rough, nothing, bounce},
                                                {"driven wall", rough, nothing, drive},
                                                {"a cell", rough, nothing, mark},
                                                {"layers", rough, nothing, layer}}};
    return all;
}

/// One of two that take turns.
class Runner {
public:
    Runner(const Communicator& comm, const SettledBlock& block, std::int64_t copies, const Change& change)
        : comm_(comm), block_(block), copies_(copies) {
        auto scene = bench_scene(static_cast<double>(copies) * block.length);
        change(scene);
        simulation_ = std::make_unique<Simulation<2>>(comm, scene, disk_kernels());
    }

    /// From the settled pile; the first step, which finds what differs from it, is not timed.
    void turn(int steps) {
        load_copies(*simulation_, block_, copies_);
        simulation_->mark_cells();
        simulation_->step();
        simulation_->watch().clear();
        const auto before = simulation_->counters().relaxations;
        comm_.barrier();
        const double elapsed = seconds_of([&] {
            for (int k = 0; k < steps; ++k) {
                simulation_->step();
            }
        });
        const double sweeping = simulation_->watch().seconds()[static_cast<std::size_t>(Timed::sweep)];
        const auto relaxed = comm_.sum(simulation_->counters().relaxations - before);
        contacts = comm_.sum(simulation_->contacts().n_active());
        const double per_rank = 1e9 * comm_.size();
        relaxation.push_back(per_rank * comm_.max(sweeping) / static_cast<double>(relaxed));
        rest.push_back(per_rank * comm_.max(elapsed - sweeping) / (static_cast<double>(contacts) * steps));
    }

    Features features() const { return features_of(simulation_->scene()); }
    std::int64_t grains() const { return simulation_->domain().n_grains(); }

    std::int64_t contacts = 0;
    std::vector<double> relaxation, rest; ///< [ns] of every turn

private:
    const Communicator& comm_;
    const SettledBlock& block_;
    std::int64_t copies_;
    std::unique_ptr<Simulation<2>> simulation_;
};

FeatureFigures measure(const Communicator& comm, const SettledBlock& block, std::int64_t copies, const Feature& feature,
                       const FeatureEffort& effort) {
    Runner without(comm, block, copies, feature.without), with(comm, block, copies, feature.with);
    for (int round = 0; round < effort.rounds; ++round) {
        (round % 2 == 0 ? without : with).turn(effort.steps);
        (round % 2 == 0 ? with : without).turn(effort.steps);
    }
    const auto time = [](const std::vector<double>& one, const std::vector<double>& other) {
        return FeatureTime{quartiles(one), quartiles(other), quartiles(ratios(other, one))};
    };
    const auto more = [&](std::size_t (*bytes)(const Features&)) {
        return static_cast<std::int64_t>(bytes(with.features())) - static_cast<std::int64_t>(bytes(without.features()));
    };
    return {feature.name,
            kernel_variant(with.features()),
            without.grains(),
            without.contacts,
            more(bytes_per_grain),
            more(bytes_per_contact),
            time(without.relaxation, with.relaxation),
            time(without.rest, with.rest)};
}

} // namespace

std::vector<FeatureFigures> measure_features(const Communicator& comm, const FeatureBlocks& blocks, std::int64_t grains,
                                             const FeatureEffort& effort) {
    std::vector<FeatureFigures> figures;
    for (const auto& feature : features()) {
        const auto& block = blocks.*feature.block;
        figures.push_back(measure(comm, block, n_copies(block, grains), feature, effort));
    }
    return figures;
}

} // namespace nappe
