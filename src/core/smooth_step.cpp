#include "core/smooth_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace nappe {

namespace {

/// The smallest and the largest grain of a material, or a wall.
struct Body {
    double r = 0;     ///< [m], 0 for a wall
    double inv_m = 0; ///< [1/kg]
    double z = 0;     ///< contacts that it may have at once
};

double mass_of(const Material& material, double r) {
    return material.density * std::numbers::pi * r * r;
}

class Bodies {
public:
    explicit Bodies(const Scene<2>& scene)
        : radii_(scene.materials.size()), counts_(scene.materials.size()), of_walls_(scene.materials.size()) {
        if (scene.sample) { // of many grains
            take(scene.sample->material, scene.sample->radii.min);
            take(scene.sample->material, scene.sample->radii.max);
        }
        for (const auto& grain : scene.grains) {
            take(grain.material, grain.radius);
        }
        for (const auto& wall : scene.walls) {
            of_walls_[static_cast<std::size_t>(wall.material)] = true;
        }
        if (!scene.sample) {
            std::size_t others = scene.grains.size() - 1;
            for (const auto& wall : scene.walls) { // each of its segments may touch
                others += wall.points.size() - 1;
            }
            most_ = static_cast<double>(others);
        }
    }

    /// As many disks of the smallest radius as fit around one of r.
    double contacts_of(double r) const {
        const double around = std::floor(std::numbers::pi / std::asin(smallest_ / (r + smallest_)) * (1 + 1e-12));
        return std::min(around, most_);
    }

    std::vector<Body> grains(const Scene<2>& scene, int material) const {
        const auto k = static_cast<std::size_t>(material);
        std::vector<Body> bodies;
        for (const double r : {radii_[k].min, radii_[k].max}) {
            if (radii_[k].max > 0) {
                bodies.push_back({r, 1 / mass_of(scene.materials[k], r), contacts_of(r)});
            }
        }
        return bodies;
    }

    /// Whether a grain of one can meet one of the other.
    bool meet(int one, int other) const { return one != other || counts_[static_cast<std::size_t>(one)] > 1; }

    bool has_wall(int material) const { return of_walls_[static_cast<std::size_t>(material)]; }

private:
    struct Radii {
        double min = std::numeric_limits<double>::infinity(), max = 0;
    };

    void take(int material, double r) {
        auto& radii = radii_[static_cast<std::size_t>(material)];
        radii = {std::min(radii.min, r), std::max(radii.max, r)};
        smallest_ = std::min(smallest_, r);
        ++counts_[static_cast<std::size_t>(material)];
    }

    std::vector<Radii> radii_;
    std::vector<std::int64_t> counts_; ///< of grains; of a sample's, two
    std::vector<bool> of_walls_;
    double smallest_ = std::numeric_limits<double>::infinity();
    double most_ = std::numeric_limits<double>::infinity();
};

/// Where lambda = -1 solves lambda² - (2 - D h - K h²) lambda + 1 - D h = 0: K h² + 2 D h = 4.
double longest_step(double stiffness, double damping) {
    return 4 / (damping + std::sqrt(damping * damping + 4 * stiffness));
}

void hold_against(const Body& a, const Body& b, const ContactLaw& law, const std::string& names, SmoothBounds& bounds) {
    const Springs& springs = *law.springs;
    // Each grain's mass is shared among its contacts: the oscillation of the whole is no faster than that of its fastest
    // part (the largest eigenvalue of a sum of elements).
    const double shared = a.z * a.inv_m + b.z * b.inv_m;
    const double critical_dashpot = 2 * std::sqrt(springs.normal.k / (a.inv_m + b.inv_m));
    for (const bool tangential : {false, true}) {
        if (tangential && law.friction == 0) {
            continue;
        }
        const auto& spring = tangential ? springs.tangential : springs.normal;
        const double rim = tangential ? 3 : 1; // a disk's rim is moved by 1/m + r²/I
        const double h = longest_step(rim * spring.k * shared, rim * spring.c.value_or(critical_dashpot) * shared);
        if (h < bounds.stable) {
            bounds.stable = h;
            bounds.contact = fmt::format("{}, {} with {}", names,
                                         b.inv_m > 0 ? fmt::format("radii {:.3g} and {:.3g} m", a.r, b.r)
                                                     : fmt::format("radius {:.3g} m on a wall", a.r),
                                         tangential ? "their tangential spring" : "their normal spring");
        }
    }
}

} // namespace

SmoothBounds smooth_bounds(const Scene<2>& scene) {
    const Bodies bodies(scene);
    SmoothBounds bounds;
    double most_inv_m = 0, most_k = 0;
    const auto name = [&](int material) { return scene.materials[static_cast<std::size_t>(material)].name; };
    for (const auto& law : scene.laws) {
        most_k = std::max({most_k, law.springs->normal.k, law.springs->tangential.k});
        const auto names = fmt::format("{} and {}", name(law.material_a), name(law.material_b));
        for (const auto& [one, other] :
             {std::pair(law.material_a, law.material_b), std::pair(law.material_b, law.material_a)}) {
            for (const Body& a : bodies.grains(scene, one)) {
                for (const Body& b : bodies.meet(one, other) ? bodies.grains(scene, other) : std::vector<Body>()) {
                    hold_against(a, b, law, names, bounds);
                }
                if (bodies.has_wall(other)) {
                    hold_against(a, {}, law, names, bounds);
                }
            }
        }
    }
    for (int m = 0; m < static_cast<int>(scene.materials.size()); ++m) {
        const auto& material = scene.materials[static_cast<std::size_t>(m)];
        for (const Body& grain : bodies.grains(scene, m)) {
            most_inv_m = std::max(most_inv_m, grain.inv_m);
            const double inertia = 0.5 * grain.r * grain.r / grain.inv_m;
            const double h = 2 * inertia / material.spin_damping; // a = C* h / 2I = 1
            if (material.spin_damping > 0 && h < bounds.spin_flips) {
                bounds.spin_flips = h;
                bounds.spin = fmt::format("{} of radius {:.3g} m", material.name, grain.r);
            }
        }
    }
    bounds.critical = 2 / std::sqrt(most_k * most_inv_m);
    return bounds;
}

std::vector<std::string> smooth_warnings(const Scene<2>& scene) {
    std::vector<std::string> lines;
    for (const auto& stage : scene.stages) {
        if (!is_smooth(stage.solver)) {
            continue;
        }
        const auto bounds = smooth_bounds(scene);
        const double h = stage.solver.h / stage.solver.substeps;
        if (h > bounds.stable) {
            lines.push_back(fmt::format("stage '{}': a step of {:.3g} s is unsafe, as allowed: oscillations may grow "
                                        "beyond {:.3g} s ({})",
                                        stage.name, h, bounds.stable, bounds.contact));
        }
        if (h > 0.1 * bounds.critical) {
            lines.push_back(fmt::format("stage '{}': a step of {:.3g} s is more than a tenth of dt_crit = 2 "
                                        "sqrt(m_min/k_max) = {:.3g} s; overlaps may be inaccurate",
                                        stage.name, h, bounds.critical));
        }
        if (h > bounds.spin_flips) {
            lines.push_back(fmt::format("stage '{}': spin_damping turns the spin of {} around in every step of more "
                                        "than {:.3g} s, found {:.3g} s",
                                        stage.name, bounds.spin, bounds.spin_flips, h));
        }
    }
    return lines;
}

} // namespace nappe
