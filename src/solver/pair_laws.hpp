#pragma once
// The laws of a scene as the packing of contacts asks for them.

#include "core/scene.hpp"

#include <cstddef>
#include <vector>

namespace nappe {

/// Friction and restitution of every pair of materials, as a table.
struct PairLaws {
    explicit PairLaws(const Scene<2>& scene);

    double friction(int a, int b) const { return friction_[static_cast<std::size_t>(a * n_ + b)]; }
    double restitution(int a, int b) const { return restitution_[static_cast<std::size_t>(a * n_ + b)]; }

    bool uniform = true; ///< one friction coefficient serves all pairs
    double uniform_friction = 0;
    bool any_restitution = false; ///< else no approach velocity is ever computed

private:
    int n_ = 0;
    std::vector<double> friction_, restitution_;
};

} // namespace nappe
