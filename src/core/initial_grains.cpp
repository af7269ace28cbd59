#include "core/initial_grains.hpp"

#include "core/deposit.hpp"
#include "core/lattice.hpp"

#include <fmt/core.h>

#include <numbers>

namespace nappe {

std::vector<GrainRow<2>> initial_grains(const Scene<2>& scene) {
    std::vector<GrainRow<2>> rows;
    if (scene.sample) {
        const auto material = static_cast<std::size_t>(scene.sample->material);
        const double density = scene.materials[material].density;
        rows = scene.sample->arrangement == Sample<2>::Arrangement::deposit
                   ? deposit(*scene.sample, density, scene.gravity)
                   : lattice(*scene.sample, density);
        for (auto& row : rows) {
            row.material = scene.sample->material;
        }
    }
    for (const auto& single : scene.grains) {
        if (!single.drop) {
            rows.push_back(single_grain(scene, single, static_cast<GlobalId>(rows.size())));
        }
    }
    return rows;
}

GrainRow<2> single_grain(const Scene<2>& scene, const SingleGrain<2>& single, GlobalId id) {
    GrainRow<2> row;
    row.id = id;
    row.x = {single.position[0], single.position[1]};
    row.v = {single.velocity[0], single.velocity[1]};
    row.spin = {single.spin[0]};
    row.radius = single.radius;
    row.mass = scene.materials[static_cast<std::size_t>(single.material)].density * std::numbers::pi * single.radius *
               single.radius;
    row.material = single.material;
    row.layer = single.layer;
    return row;
}

std::optional<std::int64_t> known_size(const Scene<2>& scene) {
    const auto single = static_cast<std::int64_t>(scene.grains.size());
    if (!scene.sample) {
        return single;
    }
    if (scene.sample->arrangement == Sample<2>::Arrangement::deposit) {
        return {};
    }
    return single + lattice_size(*scene.sample);
}

std::string probe_fault(const Probe& probe, std::int64_t n) {
    if (probe.grain >= -n && probe.grain < n) {
        return "";
    }
    return fmt::format(
        "must be < {}, the number of grains, and >= -{}, which is the first of them, found {}; grains of "
        "the sample come first, then those of [[grains]], those that are dropped last; -1 is the last",
        n, n, probe.grain);
}

} // namespace nappe
