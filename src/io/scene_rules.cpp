#include "io/scene_rules.hpp"

#include "core/initial_grains.hpp"
#include "core/lattice.hpp"
#include "core/smooth_step.hpp"
#include "io/scene_geometry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace nappe::scene_file {

namespace {

/// Smallest and largest radius of the scene [m].
struct Radii {
    double min = no_limit;
    double max = 0;
};

Radii radii_of(const Scene<2>& scene) {
    Radii radii;
    if (scene.sample) {
        radii = {scene.sample->radii.min, scene.sample->radii.max};
    }
    for (const auto& grain : scene.grains) {
        radii = {std::min(radii.min, grain.radius), std::max(radii.max, grain.radius)};
    }
    return radii;
}

/// A point as the file has it: with the origin, up to what was rounded off when it was taken away.
std::string shown(const Scene<2>& scene, const Vec<2>& p) {
    return fmt::format("[{:.15g}, {:.15g}]", p[0] + scene.origin[0], p[1] + scene.origin[1]);
}

const Material& material(const Scene<2>& scene, int index) {
    return scene.materials[static_cast<std::size_t>(index)];
}

/// A rebound is due to the velocity at the start of a substep: gaps that are only carried on do not tell when.
void check_kept_geometry(const Scene<2>& scene, Problems& problems) {
    const bool rebounds =
        std::any_of(scene.laws.begin(), scene.laws.end(), [](const auto& law) { return law.restitution > 0; });
    for (const auto& stage : scene.stages) {
        if (rebounds && stage.solver.geometry_every > 1) {
            problems.add("solver.geometry_every",
                         fmt::format("must be 1 where a law has restitution, found {} in stage '{}'; leave it out",
                                     stage.solver.geometry_every, stage.name));
            return;
        }
    }
}

/// Grains that are moved apart stretch their bonds, which is energy that nothing paid for.
void check_correction(const Scene<2>& scene, Problems& problems) {
    const bool attracts =
        std::any_of(scene.laws.begin(), scene.laws.end(), [](const auto& law) { return law.gamma > 0; });
    for (const auto& stage : scene.stages) {
        if (attracts && stage.solver.position_correction > 0) {
            problems.add("solver.position_correction",
                         fmt::format("must be 0 where a law attracts (gamma > 0), found {} in stage '{}'; leave it out",
                                     stage.solver.position_correction, stage.name));
            return;
        }
    }
}

/// Stages without a solution: what they go by must be there, and what they have no part in must not be asked of them.
void check_smooth_stages(const Scene<2>& scene, Problems& problems) {
    const auto smooth = std::find_if(scene.stages.begin(), scene.stages.end(),
                                     [](const Stage& stage) { return is_smooth(stage.solver); });
    if (smooth == scene.stages.end()) {
        return;
    }
    bool complete = true;
    for (const auto& law : scene.laws) {
        if (!law.springs) {
            complete = false;
            problems.add("laws",
                         fmt::format("must all have type = \"cundall\" where a stage has method = \"cundall\", found "
                                     "that of \"{}\" and \"{}\" without springs, and stage '{}'; give it k_n",
                                     material(scene, law.material_a).name, material(scene, law.material_b).name,
                                     smooth->name));
        }
    }
    for (const auto& stage : scene.stages) {
        if (!is_smooth(stage.solver)) {
            continue;
        }
        const double h = stage.solver.h / stage.solver.substeps;
        if (const auto bounds = complete ? smooth_bounds(scene) : SmoothBounds{};
            h > bounds.stable && !stage.solver.unsafe) {
            problems.add("solver.h",
                         fmt::format("must be at most {:.4g} s with method = \"cundall\", or oscillations of "
                                     "{} may grow, found {:.4g} s a substep in stage '{}'; take a smaller "
                                     "step, or say unsafe = true",
                                     bounds.stable, bounds.contact, h, stage.name));
        }
    }
}

/// Grains weigh something, and every pair of materials that can meet has a law.
void check_materials(const Scene<2>& scene, Problems& problems) {
    std::set<int> of_grains;
    std::set<int> of_walls;
    if (scene.sample) {
        of_grains.insert(scene.sample->material);
    }
    for (const auto& grain : scene.grains) {
        of_grains.insert(grain.material);
    }
    for (const auto& wall : scene.walls) {
        of_walls.insert(wall.material);
    }
    for (const int grain : of_grains) {
        const auto& name = material(scene, grain).name;
        if (material(scene, grain).density == 0) {
            problems.add(fmt::format("materials.{}.density", name),
                         "must be > 0 [kg/m³] where grains are made of the material, found nothing; give the density");
        }
        auto partners = of_walls;
        partners.insert(of_grains.lower_bound(grain), of_grains.end());
        for (const int partner : partners) {
            if (find_law(scene, grain, partner) == nullptr) {
                const auto& other = material(scene, partner).name;
                problems.add("laws", fmt::format("must cover every pair of materials that can meet, found none between "
                                                 "\"{0}\" and \"{1}\"; add [[laws]] with between = [\"{0}\", \"{1}\"]",
                                                 name, other));
            }
        }
    }
}

void check_wall_points(const Scene<2>& scene, Problems& problems) {
    for (const auto& wall : scene.walls) {
        const auto path = fmt::format("walls.{}.points", wall.name);
        if (wall.points.size() < 2) {
            problems.add(path,
                         fmt::format("must be at least 2 points, found {}; a wall is a line", wall.points.size()));
        }
        for (std::size_t k = 1; k < wall.points.size(); ++k) {
            if (wall.points[k] == wall.points[k - 1]) {
                problems.add(fmt::format("{}.{}", path, k),
                             fmt::format("must differ from the point before it, found {} twice; remove one",
                                         shown(scene, wall.points[k])));
            }
        }
    }
}

/// Whether all points lie on one line, up to round-off.
bool is_flat(const std::vector<Vec<2>>& points) {
    Vec<2> longest = Vec<2>::Zero();
    for (const auto& p : points) {
        const Vec<2> reach = p - points[0];
        longest = reach.squaredNorm() > longest.squaredNorm() ? reach : longest;
    }
    return std::all_of(points.begin(), points.end(), [&](const Vec<2>& p) {
        const Vec<2> reach = p - points[0];
        return std::abs(longest[0] * reach[1] - longest[1] * reach[0]) <= 1e-12 * longest.squaredNorm();
    });
}

/// True if the profile is a sound polygon that has room for a grain.
bool check_profile(const Scene<2>& scene, Problems& problems) {
    const auto& sample = *scene.sample;
    const auto& profile = sample.profile;
    const std::string path = "sample.profile";
    if (profile.size() < 3) {
        problems.add(path, fmt::format("must be at least 3 points, found {}; give the corners of the sample in order",
                                       profile.size()));
        return false;
    }
    for (std::size_t k = 1; k < profile.size(); ++k) {
        if (profile[k] == profile[k - 1]) {
            problems.add(fmt::format("{}.{}", path, k),
                         fmt::format("must differ from the point before it, found {} twice; remove one",
                                     shown(scene, profile[k])));
            return false;
        }
    }
    if (profile.front() == profile.back()) {
        problems.add(
            fmt::format("{}.{}", path, profile.size() - 1),
            fmt::format("must differ from the first point, found {} again; remove it, the polygon closes by itself",
                        shown(scene, profile.back())));
        return false;
    }
    if (is_flat(profile)) {
        problems.add(path, "must enclose an area > 0 [m²], found all points on one line; check the corners");
        return false;
    }
    if (const auto edges = crossing_edges(profile)) {
        problems.add(
            fmt::format("{}.{}", path, edges->second),
            fmt::format("must not cross or touch itself, found edges {} and {} (from 0) meeting; give the corners in "
                        "order around the sample",
                        edges->first, edges->second));
        return false;
    }
    if (!holds_circle(profile, sample.radii.max)) {
        problems.add(path, fmt::format("must have room for a grain of the largest radius, {} [m], found it too narrow "
                                       "everywhere (area {} m²); widen it or use smaller grains",
                                       sample.radii.max, std::abs(signed_area(profile))));
        return false;
    }
    if (sample.arrangement != Sample<2>::Arrangement::deposit) {
        if (const auto fault = lattice_fault(sample); !fault.key.empty()) {
            problems.add("sample." + fault.key, fault.text);
            return false;
        }
    }
    return true;
}

/// The deposit fills the profile and knows nothing of walls or other grains: nothing may be in its way.
void check_profile_is_free(const Scene<2>& scene, Problems& problems) {
    const auto& sample = *scene.sample;
    const double tolerance = 1e-6 * sample.radii.min;
    for (const auto& wall : scene.walls) {
        for (std::size_t k = 1; k < wall.points.size(); ++k) {
            const double reached = depth_of_segment(sample.profile, wall.points[k - 1], wall.points[k]);
            if (reached > tolerance) {
                problems.add(
                    fmt::format("walls.{}.points.{}", wall.name, k - 1),
                    fmt::format("must stay out of sample.profile, found the segment from {} to {} at least {:.3g} m "
                                "inside; move the wall, or cut it out of the profile",
                                shown(scene, wall.points[k - 1]), shown(scene, wall.points[k]), reached));
                break;
            }
        }
    }
    for (std::size_t i = 0; i < scene.grains.size(); ++i) {
        const auto& grain = scene.grains[i];
        if (!grain.drop && depth(sample.profile, grain.position) > tolerance - grain.radius) {
            problems.add(fmt::format("grains.{}.position", i),
                         fmt::format("must keep the grain out of sample.profile, found {} with radius {} [m]; move it",
                                     shown(scene, grain.position), grain.radius));
        }
    }
}

/// Two grains, or a grain and a wall, whose contact normal would have no meaning. Smaller overlaps are the user's.
void check_single_grains(const Scene<2>& scene, Problems& problems) {
    std::vector<std::size_t> by_x(scene.grains.size());
    std::iota(by_x.begin(), by_x.end(), std::size_t{0});
    std::sort(by_x.begin(), by_x.end(),
              [&](std::size_t a, std::size_t b) { return scene.grains[a].position[0] < scene.grains[b].position[0]; });
    const double largest = radii_of(scene).max;
    for (std::size_t k = 0; k < by_x.size(); ++k) {
        const auto& a = scene.grains[by_x[k]];
        for (std::size_t l = k + 1; l < by_x.size(); ++l) {
            const auto& b = scene.grains[by_x[l]];
            if (b.position[0] - a.position[0] > largest) {
                break;
            }
            if (!a.drop && !b.drop && (b.position - a.position).norm() < std::max(a.radius, b.radius)) {
                const auto [first, second] = std::minmax(by_x[k], by_x[l]);
                problems.add(
                    fmt::format("grains.{}.position", second),
                    fmt::format("must lie outside the other grains, found its centre or that of grain {} (from 0) "
                                "inside the other; move one of them",
                                first));
            }
        }
        for (const auto& wall : scene.walls) {
            for (std::size_t p = 1; p < wall.points.size(); ++p) {
                const Vec<2> nearest = nearest_on_segment(wall.points[p - 1], wall.points[p], a.position);
                const double distance = (nearest - a.position).norm();
                if (!a.drop && distance < a.radius / 2) {
                    problems.add(
                        fmt::format("grains.{}.position", by_x[k]),
                        fmt::format(
                            "must be at least half a radius ({} m) from every wall, found {:.3g} m from \"{}\"; "
                            "move the grain or the wall",
                            a.radius / 2, distance, wall.name));
                    break;
                }
            }
        }
    }
}

/// Beyond 1e7 radii a double places a grain no better than 1e-9 of its radius, the deposit's own accuracy. What files
/// hold is counted from [0, 0]: beyond 2^33 radii no better than 2e-6.
void check_extent(const Scene<2>& scene, const Radii& radii, Problems& problems) {
    const double limit = 1e7 * radii.min, farthest = 0x1p33 * radii.min;
    if (scene.origin.cwiseAbs().maxCoeff() > farthest) {
        problems.add("world.origin",
                     fmt::format("must lie within 2^33 smallest radii ({:.6g} m) of [0, 0], found {}; give coordinates "
                                 "from a nearer point",
                                 farthest, shown(scene, Vec<2>::Zero())));
    }
    const auto check = [&](const std::string& path, const Vec<2>& p) {
        if (p.cwiseAbs().maxCoeff() > limit) {
            problems.add(path, fmt::format("must lie within 1e7 smallest radii ({:.6g} m) of world.origin, found {}; "
                                           "shift the origin, or the scene",
                                           limit, shown(scene, p)));
        }
    };
    for (std::size_t k = 0; scene.sample && k < scene.sample->profile.size(); ++k) {
        check(fmt::format("sample.profile.{}", k), scene.sample->profile[k]);
    }
    for (std::size_t i = 0; i < scene.grains.size(); ++i) {
        check(fmt::format("grains.{}.position", i), scene.grains[i].position);
    }
    for (const auto& wall : scene.walls) {
        for (std::size_t k = 0; k < wall.points.size(); ++k) {
            check(fmt::format("walls.{}.points.{}", wall.name, k), wall.points[k]);
        }
    }
}

void check_zone(const Scene<2>& scene, Problems& problems) {
    const auto& zone = scene.output.zone;
    if (zone && !scene.walls[static_cast<std::size_t>(zone->wall)].motion) {
        problems.add("output.zone.wall",
                     fmt::format("must be a wall with a motion, found \"{}\"; limits are sought against the speed of "
                                 "the wall that drives",
                                 scene.walls[static_cast<std::size_t>(zone->wall)].name));
    }
}

/// Coupled once a sweep, results depend on who owns what, so no clock may have a part in it.
void check_coupling(const Scene<2>& scene, Problems& problems) {
    if (!couples_by_sweep(scene)) {
        return;
    }
    const auto refuse = [&](const char* key, const char* wanted, const char* found) {
        problems.add(
            key, fmt::format("must be \"{}\" with solver.coupling = \"sweep\", found \"{}\": results then depend on "
                             "who owns which tiles; set balance.by = \"work\" and balance.moves = \"always\"",
                             wanted, found));
    };
    if (scene.balance.by != BalanceSettings::By::work) {
        refuse("balance.by", "work", "time");
    }
    if (scene.balance.moves != BalanceSettings::Moves::always) {
        refuse("balance.moves", "always", "when_it_pays");
    }
}

/// Those of a deposit are looked for when it is made.
void check_probed_grains(const Scene<2>& scene, Problems& problems) {
    const auto n = known_size(scene);
    for (const auto& probe : scene.output.probes) {
        if (const auto fault = n ? probe_fault(probe, *n) : ""; !fault.empty()) {
            problems.add(fmt::format("output.probes.{}.grain", probe.name), fault);
        }
    }
}

} // namespace

void check_rules(const Scene<2>& scene, Problems& problems) {
    if (!scene.sample && scene.grains.empty()) {
        problems.add("sample", "a scene must have grains, found neither [sample] nor [[grains]]; add one of them");
        return;
    }
    const Radii radii = radii_of(scene);
    check_materials(scene, problems);
    check_kept_geometry(scene, problems);
    check_correction(scene, problems);
    check_smooth_stages(scene, problems);
    check_wall_points(scene, problems);
    check_zone(scene, problems);
    check_coupling(scene, problems);
    check_tiles(scene, problems);
    check_sizes(scene, radii.min, problems);
    check_extent(scene, radii, problems);
    if (!problems.empty()) {
        return; // what follows takes sizes and distances for sound
    }
    const bool sound = !scene.sample || check_profile(scene, problems);
    if (scene.sample && sound) {
        check_profile_is_free(scene, problems);
    }
    if (sound) {
        check_probed_grains(scene, problems);
    }
    check_single_grains(scene, problems);
}

} // namespace nappe::scene_file
