// The energy of a step, for scenes that ask for it (output.measures.energy): it visits every grain and contact once
// more.

#include "solver/simulation.hpp"

namespace nappe {

/// Adds the step in hand: between the solution of its contacts and integrate, when u_old and u are its velocities.
template <int D>
void Simulation<D>::collect_energy(double h) {
    const auto lap = watch_.lap(Timed::measure);
    settle_records();
    for (std::size_t t = 0; t < candidates_.counted_tiles().size(); ++t) {
        const auto& tile = candidates_.tiles[t];
        for (LocalId i = tile.grains_begin; i < tile.grains_end; ++i) {
            energy_.add_grain(state_.mass[i], state_.u_old[i], state_.u[i], scene_.gravity, h, settings().theta);
        }
        if (smooth()) {
            collect_springs(t, h);
            energy_.end_tile();
            continue;
        }
        contacts_.for_each(t, [&](LocalId a, LocalId b, const Vec<D>& n, double r_n, double r_t) {
            energy_.add_contact(state_.u_old[a], state_.u[a], state_.u_old[b], state_.u[b], n, r_n, r_t);
        });
        energy_.end_tile();
    }
}

template void Simulation<2>::collect_energy(double);

} // namespace nappe
