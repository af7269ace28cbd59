#include "solver/pair_laws.hpp"

namespace nappe {

PairLaws::PairLaws(const Scene<2>& scene) : n_(static_cast<int>(scene.materials.size())) {
    friction_.assign(static_cast<std::size_t>(n_ * n_), 0.0);
    restitution_ = gamma_ = range_ = friction_;
    for (std::size_t k = 0; k < scene.laws.size(); ++k) {
        const auto& law = scene.laws[k];
        for (const int at : {law.material_a * n_ + law.material_b, law.material_b * n_ + law.material_a}) {
            friction_[static_cast<std::size_t>(at)] = law.friction;
            restitution_[static_cast<std::size_t>(at)] = law.restitution;
            gamma_[static_cast<std::size_t>(at)] = law.gamma;
            range_[static_cast<std::size_t>(at)] = law.range();
        }
        any_friction = any_friction || law.friction > 0;
        any_restitution = any_restitution || law.restitution > 0;
        any_cohesion = any_cohesion || law.gamma > 0;
        uniform = uniform && law.friction == scene.laws.front().friction;
    }
    uniform_friction = scene.laws.empty() ? 0.0 : scene.laws.front().friction;
}

} // namespace nappe
