#pragma once
// Heavy on light and light on heavy: scenes whose forces statics knows, for a mass ratio of the caller's. The one list
// of them: every solver and every named accuracy is asked the same questions (heavy_test.cpp).

#include "extremes/findings.hpp"

namespace nappe::test {

/// A force that statics fixes: of grain `lo` on grain `hi`, or on wall `-1 - hi` (SerialRun::normal_impulse).
struct KnownForce {
    GlobalId lo = 0;
    GlobalId hi = 0;
    double newtons = 0; ///< per metre of depth
};

struct HeavyScene {
    const char* name;
    double ratio;   ///< of masses
    Scene<2> scene; ///< no stage yet
    std::vector<KnownForce> known;
    double factor = 0; ///< force error <= factor x residual, derived in heavy_test.cpp
    double weight = 0; ///< of all grains [N]: forces are judged by it
};

/// A contact problem solved once from nothing, and how wrong its forces are.
struct ColdStep {
    int sweeps = 0;
    double residual = 0;    ///< largest, over V = h g
    double force_error = 0; ///< largest of the known forces', over the weight
    bool converged = true;  ///< as the solver says, if it had a tolerance
};

inline constexpr double light_radius = 0.37;  ///< [m]; no binary fraction, so that gaps have round-off
inline constexpr double light_density = 2800; ///< [kg/m³]

/// Disks of one radius on top of each other, the last or the first heavier by `ratio`.
inline HeavyScene column(const char* name, double ratio, int n, bool heavy_on_top) {
    SceneBuilder b(0);
    const double r = light_radius;
    const int heavy = b.material("lead", light_density * ratio);
    b.law(0, heavy, 0).law(heavy, heavy, 0).floor(10);
    std::vector<double> weights;
    for (int k = 0; k < n; ++k) {
        const bool is_heavy = k == (heavy_on_top ? n - 1 : 0);
        b.grain(r, {0, r * (2 * k + 1)}, {0, 0}, 0, is_heavy ? heavy : 0);
        weights.push_back(disk_mass(r, light_density * (is_heavy ? ratio : 1)) * standard_gravity);
    }
    HeavyScene scene{name, ratio, b.scene(), {}, static_cast<double>(n)};
    for (int k = n - 1; k >= 0; --k) { // what stands on contact k
        scene.weight += weights[static_cast<std::size_t>(k)];
        scene.known.push_back({k == 0 ? 0 : k - 1, k == 0 ? wall_id(0) : k, scene.weight});
    }
    return scene;
}

/// A disk of `size` times the radius on the middle two of a row of n small ones between walls, all without friction. These
/// two stand a gap apart (touching, they could press each other with any force); the big one rests on two contacts at the
/// angle phi from the vertical, sin phi = (r + gap/2)/(R + r), and presses them apart with M g tan(phi)/2, which goes
/// through the row to both walls.
inline HeavyScene cushion(const char* name, double ratio, int n, double size) {
    const double r = light_radius, big = size * r;
    const double gap = 0.2 * r, middle = r * n + gap / 2;
    const double sine = (r + gap / 2) / (big + r), cosine = std::sqrt(1 - sine * sine);
    SceneBuilder b(0);
    const int heavy = b.material("lead", light_density * ratio / (size * size));
    b.law(0, heavy, 0).law(heavy, heavy, 0);
    b.wall("floor", {{0, 0}, {2 * middle, 0}});
    b.wall("left", {{0, 1.5 * r}, {0, 0}}).wall("right", {{2 * middle, 0}, {2 * middle, 1.5 * r}});
    for (int k = 0; k < n; ++k) {
        b.grain(r, {r * (2 * k + 1) + (k < n / 2 ? 0.0 : gap), r});
    }
    b.grain(big, {middle, r + cosine * (big + r)}, {0, 0}, 0, heavy);
    const double small_weight = disk_mass(r, light_density) * standard_gravity;
    const double big_weight = ratio * small_weight;
    const double push = 0.5 * big_weight * sine / cosine;
    const double reach = 1 + cosine + 0.5 * n * sine;
    HeavyScene scene{name, ratio, b.scene(), {}, 0.5 * reach * (1 / (cosine * cosine) + 1 / (sine * sine)) + n};
    scene.weight = big_weight + n * small_weight;
    for (int k = 0; k < n; ++k) {
        const bool carries = k == n / 2 - 1 || k == n / 2;
        scene.known.push_back({k, wall_id(0), small_weight + (carries ? 0.5 * big_weight : 0.0)});
        if (carries) {
            scene.known.push_back({k, n, 0.5 * big_weight / cosine});
        }
        if (k + 1 < n && k + 1 != n / 2) {
            scene.known.push_back({k, k + 1, push});
        }
    }
    scene.known.push_back({0, wall_id(1), push});
    scene.known.push_back({n - 1, wall_id(2), push});
    return scene;
}

/// A heavy disk on three layers of small ones, a crystal with friction between walls without: forces between the grains
/// are not unique, but the floor carries everything.
inline HeavyScene bed(const char* name, double ratio, int n, double size) {
    const double r = light_radius, big = size * r;
    SceneBuilder b(0.4);
    const int heavy = b.material("lead", light_density * ratio / (size * size)), smooth = b.material("smooth");
    b.law(0, heavy, 0.4).law(heavy, heavy, 0.4).law(0, smooth, 0).law(heavy, smooth, 0);
    b.wall("floor", {{0, 0}, {2 * r * n, 0}}, smooth);
    b.wall("left", {{0, 10 * r}, {0, 0}}, smooth).wall("right", {{2 * r * n, 0}, {2 * r * n, 10 * r}}, smooth);
    const double rise = std::sqrt(3.0) * r;
    int count = 0;
    for (int layer = 0; layer < 3; ++layer) {
        for (int k = 0; k < n - layer % 2; ++k, ++count) {
            b.grain(r, {r * (2 * k + 1 + layer % 2), r + layer * rise});
        }
    }
    const double sine = r / (big + r);
    b.grain(big, {r * n, r + 2 * rise + std::sqrt(1 - sine * sine) * (big + r)}, {0, 0}, 0, heavy);
    HeavyScene scene{name, ratio, b.scene(), {}, n + 1.0};
    scene.weight = (count + ratio) * disk_mass(r, light_density) * standard_gravity;
    scene.known.push_back({-1, wall_id(0), scene.weight}); // of any grain on the floor
    return scene;
}

inline std::vector<HeavyScene> heavy_scenes(double ratio) {
    return {column("heavy on one", ratio, 2, true), column("heavy on four", ratio, 5, true),
            column("four on heavy", ratio, 5, false), cushion("heavy on a row", ratio, 8, 4),
            bed("heavy on three layers", ratio, 8, 4)};
}

/// Largest error of the known forces after a step of h, over the weight.
inline double force_error(SerialRun& run, const HeavyScene& scene, double h) {
    const auto contacts = run.loaded_contacts();
    double worst = 0;
    for (const auto& f : scene.known) {
        double impulse = 0;
        for (const auto& c : contacts) {
            const bool of_pair = (f.lo < 0 || c.lo == f.lo) && (f.hi >= 0 ? c.hi == f.hi : c.wall == -1 - f.hi);
            impulse += of_pair ? c.r_n * (f.lo < 0 ? c.normal[1] : 1.0) : 0.0;
        }
        worst = std::max(worst, std::abs(impulse / h - f.newtons) / scene.weight);
    }
    return worst;
}

/// One step from rest without a memory of impulses.
inline ColdStep solve_cold(const HeavyScene& heavy, const SolverSettings& settings) {
    Scene<2> scene = heavy.scene;
    Stage stage;
    stage.name = "rest";
    stage.duration = 1;
    stage.solver = settings;
    scene.stages = {stage};
    SerialRun run(scene);
    run.steps(1, true);
    return {run.simulation().last_sweeps(), run.simulation().last_residual()->largest,
            force_error(run, heavy, settings.h / settings.substeps), run.simulation().counters().unconverged == 0};
}

} // namespace nappe::test
