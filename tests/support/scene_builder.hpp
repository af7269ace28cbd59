#pragma once
// Scenes by hand, for tests of the mechanics: a material, its law, walls, grains one by one or a deposit, stages.

#include "core/scene.hpp"

#include <string>
#include <utility>
#include <vector>

namespace nappe::test {

inline constexpr double standard_gravity = 9.81; ///< [m/s²]

/// NSGS with a fixed number of sweeps. @param h [s]
inline SolverSettings solver(double h, int sweeps, double theta = 0.5) {
    SolverSettings s;
    s.h = h;
    s.sweeps = sweeps;
    s.theta = theta;
    return s;
}

/// Starts with material 0, of 2800 kg/m³, its law with itself, and gravity along -y; every member adds to that.
class SceneBuilder {
public:
    explicit SceneBuilder(double friction = 0, double restitution = 0) {
        scene_.title = "a test's scene";
        scene_.gravity = {0, -standard_gravity};
        scene_.materials.push_back({"rock", 2800});
        law(0, 0, friction, restitution);
    }

    SceneBuilder& gravity(double x, double y) {
        scene_.gravity = {x, y};
        return *this;
    }

    /// @returns its index.
    int material(const std::string& name, double density = 2800) {
        scene_.materials.push_back({name, density});
        return static_cast<int>(scene_.materials.size()) - 1;
    }

    SceneBuilder& law(int a, int b, double friction, double restitution = 0) {
        scene_.laws.push_back({a, b, friction, restitution});
        return *this;
    }

    /// The law between a and b, which must be there, attracts. @param gamma [N] @param d_w [m]
    SceneBuilder& cohesion(int a, int b, double gamma, double d_w) {
        for (auto& law : scene_.laws) {
            if ((law.material_a == a && law.material_b == b) || (law.material_a == b && law.material_b == a)) {
                law.gamma = gamma;
                law.d_w = d_w;
            }
        }
        return *this;
    }

    SceneBuilder& wall(const std::string& name, std::vector<Vec<2>> points, int material = 0) {
        scene_.walls.push_back({name, material, std::move(points), {}});
        return *this;
    }

    SceneBuilder& moving_wall(const std::string& name, std::vector<Vec<2>> points, const Motion<2>& motion) {
        scene_.walls.push_back({name, 0, std::move(points), motion});
        return *this;
    }

    /// A level floor at y = 0 over |x| <= half_length.
    SceneBuilder& floor(double half_length = 100, int material = 0) {
        return wall("floor", {{-half_length, 0}, {half_length, 0}}, material);
    }

    /// Their GlobalIds are 0, 1, … in the order of the calls. @param spin [rad/s]
    SceneBuilder& grain(double radius, const Vec<2>& position, const Vec<2>& velocity = {0, 0}, double spin = 0,
                        int material = 0) {
        SingleGrain<2> g;
        g.material = material;
        g.radius = radius;
        g.position = position;
        g.velocity = velocity;
        g.spin[0] = spin;
        scene_.grains.push_back(g);
        return *this;
    }

    /// A deposit that fills [0, width] x [0, height], between a floor (wall 0), a left (1) and a right wall (2).
    SceneBuilder& box(double width, double height, const RadiusLaw& radii, std::uint64_t seed = 1,
                      int wall_material = 0) {
        Sample<2> sample;
        sample.radii = radii;
        sample.profile = {{0, 0}, {width, 0}, {width, height}, {0, height}};
        sample.seed = seed;
        scene_.sample = sample;
        wall("floor", {{0, 0}, {width, 0}}, wall_material);
        wall("left", {{0, 2 * height}, {0, 0}}, wall_material);
        return wall("right", {{width, 0}, {width, 2 * height}}, wall_material);
    }

    /// Loading stages in order; their duration binds nobody who counts steps.
    SceneBuilder& stage(const SolverSettings& settings) {
        Stage s;
        s.name = "stage " + std::to_string(scene_.stages.size());
        s.duration = 1;
        s.solver = settings;
        scene_.stages.push_back(s);
        return *this;
    }

    Scene<2>& scene() { return scene_; } ///< for what has no member here

private:
    Scene<2> scene_;
};

} // namespace nappe::test
