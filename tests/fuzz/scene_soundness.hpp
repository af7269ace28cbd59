#pragma once
// What everyone who computes with a scene relies on; the reader promises it of every scene that it accepts.

#include "core/polygon.hpp"
#include "core/scene.hpp"

#include <cmath>
#include <string>

namespace nappe::fuzz {

/// The first promise that the scene breaks, or "".
inline std::string fault_of_scene(const Scene<2>& scene) {
    std::string fault;
    const auto require = [&](bool holds, const char* what) { fault = fault.empty() && !holds ? what : fault; };
    // So far apart that squares and products of three of them are still numbers.
    const auto moderate = [](double a) { return std::abs(a) <= 1e40; };
    const auto fair = [&](double a) { return a >= 1e-30 && moderate(a); };
    const auto both = [&](const Vec<2>& v) { return moderate(v[0]) && moderate(v[1]); };
    const auto n_materials = static_cast<int>(scene.materials.size());
    const auto weighs = [&](int m) {
        return m >= 0 && m < n_materials && fair(scene.materials[static_cast<std::size_t>(m)].density);
    };
    const auto n_stages = static_cast<int>(scene.stages.size());

    require(both(scene.gravity) && both(scene.origin), "gravity and origin are numbers");
    for (const auto& law : scene.laws) {
        require(law.material_a >= 0 && law.material_a < n_materials && law.material_b >= 0 &&
                    law.material_b < n_materials,
                "materials of a law exist");
        require(law.friction >= 0 && moderate(law.friction) && law.restitution >= 0 && law.restitution <= 1,
                "friction and restitution are in range");
        require(law.gamma >= 0 && moderate(law.gamma) && (law.gamma == 0 || fair(law.d_w)), "cohesion is in range");
    }
    require(scene.sample || !scene.grains.empty(), "there are grains");
    if (const auto& sample = scene.sample) {
        require(fair(sample->radii.min) && fair(sample->radii.max) && sample->radii.min <= sample->radii.max,
                "radii are in order");
        require(weighs(sample->material), "the sample's grains weigh something");
        require(polygon_fault(sample->profile).empty(), "the profile is a polygon");
        for (std::size_t k = 0; k < sample->layer_tops.size(); ++k) {
            require(moderate(sample->layer_tops[k]) && (k == 0 || sample->layer_tops[k - 1] < sample->layer_tops[k]),
                    "tops of layers ascend");
        }
    }
    for (const auto& grain : scene.grains) {
        require(weighs(grain.material) && fair(grain.radius) && grain.layer >= 1, "grains weigh something");
        require(both(grain.position) && both(grain.velocity) && moderate(grain.spin[0]), "grains move by numbers");
    }
    for (const auto& wall : scene.walls) {
        require(!wall.name.empty() && wall.points.size() >= 2, "walls are lines with names");
        require(wall.material >= 0 && wall.material < n_materials, "materials of walls exist");
        for (const auto& p : wall.points) {
            require(both(p), "walls stand at numbers");
        }
        if (wall.motion) {
            require(both(wall.motion->velocity) && moderate(wall.motion->start), "walls move by numbers");
            require(wall.motion->stage >= -1 && wall.motion->stage < n_stages, "stages of motions exist");
        }
    }
    require(n_stages > 0, "there are stages");
    bool loading = false;
    for (const auto& stage : scene.stages) {
        const auto& s = stage.solver;
        require(!stage.name.empty(), "stages have names");
        require(!(loading && stage.until), "what prepares comes first");
        loading = loading || !stage.until;
        require(fair(s.h) && s.substeps >= 1 && s.sweeps >= 1 && s.max_sweeps >= 1 && s.check_every >= 1 &&
                    s.geometry_every >= 1,
                "steps and sweeps are counted from 1");
        require(s.substeps <= 1000000000 && s.sweeps <= 1000000000 && s.max_sweeps <= 1000000000,
                "sums of counts are ints");
        require(s.theta >= 0.5 && s.theta <= 1 && s.position_correction >= 0 && s.position_correction <= 1,
                "theta and correction are in range");
        const double time = stage.until ? stage.until->at_most : stage.duration;
        require(fair(time) && time / s.h <= 0x1p53, "steps can be counted");
    }
    require(fair(scene.tiles.side_for(1)) && fair(scene.tiles.skin_for(1)), "tiles have a side");
    require(scene.output.cells.size() <= 64 && scene.output.series_every >= 1 && scene.output.frames_every >= 0,
            "output is in range");
    require(scene.balance.every >= 1 && scene.balance.threshold >= 1, "balance is in range");
    if (scene.output.zone) {
        require(scene.output.zone->wall >= 0 && scene.output.zone->wall < static_cast<int>(scene.walls.size()),
                "the zone's wall exists");
    }
    return fault;
}

} // namespace nappe::fuzz
