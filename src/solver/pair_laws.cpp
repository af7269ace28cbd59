#include "solver/pair_laws.hpp"

#include <algorithm>

namespace nappe {

namespace {

bool same(const SpringDashpot& p, const SpringDashpot& q) {
    return p.k == q.k && p.c == q.c;
}

/// Whether one law's springs and friction are those of all, and one dashpot serves for both directions.
bool are_uniform(const std::vector<ContactLaw>& laws) {
    return !laws.empty() && std::all_of(laws.begin(), laws.end(), [&](const ContactLaw& law) {
        const auto &mine = law.springs, &first = laws.front().springs;
        return mine && first && same(mine->normal, mine->tangential) && same(mine->normal, first->normal) &&
               law.friction == laws.front().friction;
    });
}

} // namespace

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
    uniform_springs = are_uniform(scene.laws);
    uniform_friction = scene.laws.empty() ? 0.0 : scene.laws.front().friction;
}

} // namespace nappe
