// Energy where contacts are smooth: what springs hold and what a step gave them, dashpots, friction and global damping took.
// Apart from the step, which knows nothing of it: contacts are visited once more, and only if a budget is asked for or the
// watch has reason to.

#include "solver/smooth_energy.hpp"

#include "core/contact_geometry.hpp"

#include <cmath>

namespace nappe {

namespace {

template <int D>
SmoothMotion motion_of(const BodyVelocity<D>& a_old, const BodyVelocity<D>& a, const BodyVelocity<D>& b_old,
                       const BodyVelocity<D>& b, const Vec<D>& n) {
    static_assert(D == 2, "the tangent below is that of the plane");
    const auto opening = [&n](const auto& p, const auto& q) {
        return n[0] * (p.v[0] - q.v[0]) + n[1] * (p.v[1] - q.v[1]);
    };
    const auto along = [&n](const auto& p, const auto& q) {
        return (n[0] * (p.v[1] - q.v[1]) - n[1] * (p.v[0] - q.v[0])) - (p.s[0] + q.s[0]);
    };
    return {opening(a_old, b_old), along(a_old, b_old), opening(a, b), along(a, b)};
}

} // namespace

/// Local. Calls f(contact) for the contacts of a tile that act, in the order of candidates, between `press` and the next
/// step. Pre: records are settled.
template <int D>
template <class F>
void Simulation<D>::for_each_smooth(std::size_t tile, double h, F&& f) const {
    contacts_.for_each_spring(tile,
                              [&](LocalId a, LocalId b, const Vec<D>& n, const Impulse<D>& r, double s, double s_old) {
                                  if (r.n == 0) {
                                      return; // the disks do not overlap
                                  }
                                  const auto& law = *find_law(scene_, state_.material[a], state_.material[b]);
                                  const auto& [normal, tangential] = *law.springs;
                                  const double m_eff = 1 / (state_.u[a].inv_m + state_.u[b].inv_m);
                                  SmoothContact c;
                                  c.h = h;
                                  c.r_n = r.n;
                                  c.r_t = r.t[0];
                                  c.s = s;
                                  c.s_old = s_old;
                                  c.c_n = dashpot_of(normal, m_eff);
                                  c.c_s = dashpot_of(tangential, m_eff);
                                  c.k_n = normal.k;
                                  c.k_s = tangential.k;
                                  c.mu = law.friction;
                                  c.v = motion_of<D>(state_.u_old[a], state_.u[a], state_.u_old[b], state_.u[b], n);
                                  f(c);
                              });
}

/// Local. Adds a tile's damping and contacts to the budget.
template <int D>
void Simulation<D>::collect_springs(std::size_t tile, double h) {
    const auto& range = candidates_.tiles[tile];
    for (LocalId i = range.grains_begin; i < range.grains_end; ++i) {
        const auto& material = scene_.materials[static_cast<std::size_t>(state_.material[i])];
        energy_.add_damping(material.damping, material.spin_damping, state_.radius[i], state_.u_old[i], state_.u[i], h);
    }
    for_each_smooth(tile, h, [&](const SmoothContact& c) { energy_.add_smooth(works_of(c)); });
}

/// **Collective.** What the springs hold in the step in hand, and what it gave them [J].
template <int D>
SpringEnergy Simulation<D>::spring_growth(double h) const {
    settle_records();
    ExactSum held, gained;
    for (std::size_t t = 0; t < contacts_.n_tiles(); ++t) {
        SpringEnergy of_tile;
        for_each_smooth(t, h, [&](const SmoothContact& c) {
            const auto [of_contact, more] = spring_energy(c);
            of_tile.held += of_contact;
            of_tile.gained += more;
        });
        held.add(of_tile.held);
        gained.add(of_tile.gained);
    }
    comm_.sum(held.limbs());
    comm_.sum(gained.limbs());
    return {held.value(), gained.value()};
}

template <int D>
double elastic_energy(const Simulation<D>& simulation) {
    const auto& state = simulation.state();
    const auto& set = simulation.candidates();
    const double h = simulation.settings().h / simulation.settings().substeps;
    ExactSum sum;
    for (const auto& tile : set.tiles) {
        double of_tile = 0;
        for (auto c = tile.candidates_begin; c < tile.candidates_end; ++c) {
            const LocalId a = set.a[c], b = set.b[c];
            const auto g = contact_geometry(state, simulation.walls(), a, b);
            const auto* law = find_law(simulation.scene(), state.material[a], state.material[b]);
            if (!g.applies || !(g.gap < 0) || law == nullptr || !law->springs) {
                continue;
            }
            const auto& [normal, tangential] = *law->springs;
            of_tile += 0.5 * normal.k * g.gap * g.gap;
            const double s = set.impulse(static_cast<std::size_t>(c)).t[0] / h;
            of_tile += tangential.k > 0 ? 0.5 * s * s / tangential.k : 0.0;
        }
        sum.add(of_tile);
    }
    simulation.comm().sum(sum.limbs());
    return sum.value();
}

template <int D>
double unbalanced_force(const Simulation<D>& simulation) {
    const auto& state = simulation.state();
    const auto& scene = simulation.scene();
    const double h = simulation.settings().h / simulation.settings().substeps;
    const double g = scene.gravity.norm();
    ExactSum unbalanced, acting;
    for (std::size_t t = 0; t < simulation.candidates().tiles.size(); ++t) {
        const auto& tile = simulation.candidates().tiles[t];
        double left = 0, all = 0;
        for (LocalId i = tile.grains_begin; i < tile.grains_end; ++i) {
            const auto& material = scene.materials[static_cast<std::size_t>(state.material[i])];
            double squared = 0;
            for (int d = 0; d < D; ++d) {
                const double now = state.u[i].v[d], old = state.u_old[i].v[d];
                const double force = state.mass[i] * (now - old) / h + 0.5 * material.damping * (now + old);
                squared += force * force;
            }
            left += std::sqrt(squared);
            all += state.mass[i] * g;
        }
        simulation.contacts().for_each_summed(t, [&](LocalId, LocalId b, const Vec<D>&, double r_n, double r_t) {
            all += (b < state.n_held() ? 2 : 1) * std::sqrt(r_n * r_n + r_t * r_t) / h;
        });
        unbalanced.add(left);
        acting.add(all);
    }
    simulation.comm().sum(unbalanced.limbs());
    simulation.comm().sum(acting.limbs());
    return acting.value() > 0 ? unbalanced.value() / acting.value() : 0.0;
}

template void Simulation<2>::collect_springs(std::size_t, double);
template SpringEnergy Simulation<2>::spring_growth(double) const;
template double elastic_energy(const Simulation<2>&);
template double unbalanced_force(const Simulation<2>&);

} // namespace nappe
