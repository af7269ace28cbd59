// What a step with smooth contacts does in place of a solution (seeds/004, annex): central differences, velocities live at
// half steps, positions and forces at whole ones.
//
//     v_+ = [v_- (1 - a) + h g + h F / m] / (1 + a),   a = C h / 2m          (21)
//     w_+ = [w_- (1 - a*) + h M / I] / (1 + a*),       a* = C* h / 2I        (22)
//     x_+ = x + h v_+                                                        (23), (24): theta = 1

#include "solver/simulation.hpp"

namespace nappe {

/// Of each grain held; a function of what it is, so copies have their owner's.
template <int D>
void Simulation<D>::find_damping(double h) {
    damping_.resize(static_cast<std::size_t>(state_.n_held()));
    for (LocalId i = 0; i < state_.n_held(); ++i) {
        const auto& material = scene_.materials[static_cast<std::size_t>(state_.material[i])];
        const double inertia = 0.5 * state_.mass[i] * state_.radius[i] * state_.radius[i]; // of a disk
        damping_[static_cast<std::size_t>(i)] = {0.5 * h * material.damping / state_.mass[i],
                                                 0.5 * h * material.spin_damping / inertia};
    }
    damping_h_ = h;
}

/// What `predict` left, less the half of the damping that goes by the old velocity.
template <int D>
void Simulation<D>::damp(double h) {
    const auto lap = watch_.lap(Timed::predict);
    if (h != damping_h_ || damping_.size() != static_cast<std::size_t>(state_.n_held())) {
        find_damping(h);
    }
    for (LocalId i = 0; i < state_.n_held(); ++i) {
        const Damping& damping = damping_[static_cast<std::size_t>(i)];
        for (int d = 0; d < D; ++d) {
            state_.u[i].v[d] -= damping.a * state_.u_old[i].v[d];
        }
        for (int k = 0; k < n_spin<D>; ++k) {
            state_.u[i].s[k] -= damping.of_spin * state_.u_old[i].s[k];
        }
    }
}

/// The forces of all contacts act; then the other half of the damping.
template <int D>
void Simulation<D>::press(double h) {
    const auto lap = watch_.lap(Timed::sweep);
    if (energy_wanted_) {
        note_springs();
    }
    solver_.press(contacts_, domain_.halo(), state_.u_old, state_.u, h);
    for (LocalId i = 0; i < state_.n_held(); ++i) {
        const Damping& damping = damping_[static_cast<std::size_t>(i)];
        for (int d = 0; d < D; ++d) {
            state_.u[i].v[d] /= 1 + damping.a;
        }
        for (int k = 0; k < n_spin<D>; ++k) {
            state_.u[i].s[k] /= 1 + damping.of_spin;
        }
    }
    costs_.add(contacts_, 1, {}, {});
    last_residual_.reset();
    last_sweeps_ = 1;
    counters_.relaxations += contacts_.n_active();
    ++counters_.sweeps;
}

template void Simulation<2>::find_damping(double);
template void Simulation<2>::damp(double);
template void Simulation<2>::press(double);

} // namespace nappe
