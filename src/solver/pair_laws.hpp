#pragma once
// The laws of a scene as the packing of contacts asks for them.

#include "core/features.hpp"

#include <cstddef>
#include <vector>

namespace nappe {

/// Friction, restitution and cohesion of every pair of materials, as tables.
struct PairLaws {
    explicit PairLaws(const Scene<2>& scene);

    double friction(int a, int b) const { return friction_[static_cast<std::size_t>(a * n_ + b)]; }
    double restitution(int a, int b) const { return restitution_[static_cast<std::size_t>(a * n_ + b)]; }

    double gamma(int a, int b) const { return gamma_[static_cast<std::size_t>(a * n_ + b)]; } ///< [N]
    double range(int a, int b) const {
        return range_[static_cast<std::size_t>(a * n_ + b)];
    } ///< d_w [m], 0 if gamma is

    /// Pre: the pair has springs.
    const Springs& springs(int a, int b) const { return *springs_[static_cast<std::size_t>(a * n_ + b)]; }

    Features features;            ///< of the scene
    bool uniform_springs = false; ///< all pairs that have any have the same, with c_s = c_n, and the same friction
    double uniform_friction = 0;  ///< for all pairs, unless features.mixed_friction

private:
    int n_ = 0;
    std::vector<double> friction_, restitution_, gamma_, range_;
    std::vector<std::optional<Springs>> springs_;
};

} // namespace nappe
