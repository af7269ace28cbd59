#include "solver/pair_laws.hpp"

namespace nappe {

PairLaws::PairLaws(const Scene<2>& scene) : features(features_of(scene)), n_(static_cast<int>(scene.materials.size())) {
    friction_.assign(static_cast<std::size_t>(n_ * n_), 0.0);
    restitution_ = gamma_ = range_ = friction_;
    springs_.resize(friction_.size());
    for (const auto& law : scene.laws) {
        for (const int at : {law.material_a * n_ + law.material_b, law.material_b * n_ + law.material_a}) {
            friction_[static_cast<std::size_t>(at)] = law.friction;
            restitution_[static_cast<std::size_t>(at)] = law.restitution;
            gamma_[static_cast<std::size_t>(at)] = law.gamma;
            range_[static_cast<std::size_t>(at)] = law.range();
            springs_[static_cast<std::size_t>(at)] = law.springs;
        }
    }
    uniform_friction = scene.laws.empty() ? 0.0 : scene.laws.front().friction;
}

} // namespace nappe
