// Whether energy grew without work. What the grains of all ranks gained in a (sub)step, kinetic and potential, is exactly
// the work of walls less what contacts took (docs/measures.md, "Energy"); with too few sweeps, or a step too long, contacts
// may give instead of take. Looked at over all grains, since what one contact gives another one takes. Corrected positions
// are left out: they are paid for by what contacts took (correction.cpp). What springs of smooth contacts hold counts with
// the grains' energies.

#include "solver/simulation.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace nappe {

namespace {

/// **Collective.** Exact sums over ranks by one reduction.
template <std::size_t n>
void sum_together(const Communicator& comm, const std::array<ExactSum*, n>& sums) {
    std::vector<std::int64_t> limbs;
    for (ExactSum* sum : sums) {
        limbs.insert(limbs.end(), sum->limbs().begin(), sum->limbs().end());
    }
    comm.sum(std::span(limbs));
    auto from = limbs.begin();
    for (ExactSum* sum : sums) {
        const auto to = sum->limbs();
        std::copy(from, from + static_cast<std::ptrdiff_t>(to.size()), to.begin());
        from += static_cast<std::ptrdiff_t>(to.size());
    }
}

} // namespace

/// Local. Calls f(work) for each tile that this rank counts, where walls move [J].
template <int D>
template <class F>
void Simulation<D>::for_each_work_of_walls(F&& f) const {
    const auto moves = [](const auto& v) { return v.squaredNorm() > 0; };
    if (std::none_of(walls_.v.begin(), walls_.v.end(), moves) &&
        std::none_of(walls_.v_old.begin(), walls_.v_old.end(), moves)) {
        return;
    }
    for (std::size_t t = 0; t < candidates_.counted_tiles().size(); ++t) {
        double of_tile = 0;
        contacts_.for_each_of_walls(t, [&](LocalId, LocalId b, const Vec<D>& normal, double r_n, double r_t) {
            const auto w = static_cast<std::size_t>(walls_.feature(b - state_.n_held()).wall);
            const Vec<D> mean = 0.5 * (walls_.v_old[w] + walls_.v[w]);
            of_tile += (r_n * normal + r_t * Vec<D>(-normal[1], normal[0])).dot(mean);
        });
        f(of_tile);
    }
}

/// Local. Whether energy may have grown beyond the limit in a smooth step: if not on any rank, not in all. Sums are this
/// rank's, in any order, hence `slack`.
template <int D>
bool Simulation<D>::may_have_grown(double h, const Moved& moved) const {
    constexpr double slack = 1e-6;
    if (!bounds_.kinetic) {
        return true;
    }
    double grown = moved.kinetic - *bounds_.kinetic - h * scene_.gravity.dot(moved.momentum);
    for_each_work_of_walls([&grown](double of_tile) { grown -= of_tile; });
    return !(grown <= (1 - slack) * scene_.watch.energy.limit * (*bounds_.kinetic + bounds_.weighed));
}

/// **Collective.** Energy that n substeps brought without work, over what there is to compare it with: the kinetic energy
/// at their start, the work of walls, and the weight of all grains times their mean radius.
template <int D>
double Simulation<D>::energy_growth(double h, int n, const StepStart<D>* start, EnergyLook look) {
    ExactSum work;
    for_each_work_of_walls([&work](double of_tile) { work.add(of_tile); });
    sum_together<3>(comm_, {&gauge_.grown, &gauge_.kinetic, &work});
    const double worked = work.value(), weight = total_mass_ * scene_.gravity.norm() * mean_radius_;
    double grown = gauge_.grown.value() - worked;
    double scale = watcher_.energy_scale(gauge_.kinetic.value() + (worked < 0 ? -worked : worked) + weight,
                                         look == EnergyLook::remember);
    if (smooth()) { // springs give what they hold: nobody looks at them before they have given more than the limit
        if (!(grown > scene_.watch.energy.limit * scale)) {
            return 0;
        }
        const auto [held, gained] = spring_growth(h);
        scale += held;
        grown += gained;
    }
    if (grown > scene_.watch.energy.limit * scale && contacts_.cohesive()) {
        grown -= work_of_bonds(h, n, start);
    }
    if (!(grown > 0)) {
        return 0;
    }
    return scale > 0 ? grown / scale : std::numeric_limits<double>::infinity(); // from nothing at all
}

/// **Collective.** What the attraction of bonded pairs did on its way, by the normals and bonds of the last geometry [J].
template <int D>
double Simulation<D>::work_of_bonds(double h, int n, const StepStart<D>* start) const {
    const double theta = settings().theta;
    const auto way = [&](LocalId i) {
        Vec<D> w;
        for (int d = 0; d < D; ++d) {
            const double after = h * theta * state_.u[i].v[d];
            w[d] = i >= state_.n_held() ? n * h * (theta * state_.u[i].v[d] + (1 - theta) * state_.u_old[i].v[d])
                   : start != nullptr   ? state_.mid[i].x[d] + after - start->x[i][d]
                                        : after + h * (1 - theta) * state_.u_old[i].v[d];
        }
        return w;
    };
    ExactSum sum;
    for (std::size_t t = 0; t < candidates_.counted_tiles().size(); ++t) {
        double of_tile = 0;
        contacts_.for_each_bond(t, [&](LocalId a, LocalId b, const Vec<D>& normal, double most) {
            of_tile -= most / h * normal.dot(way(a) - way(b));
        });
        sum.add(of_tile);
    }
    comm_.sum(sum.limbs());
    return sum.value();
}

/// The contact on this rank that gave most in the last substep [J].
template <int D>
Suspect Simulation<D>::driver() const {
    settle_records();
    Suspect found;
    for (std::size_t t = 0; t < contacts_.n_tiles(); ++t) {
        contacts_.for_each(t, [&](LocalId a, LocalId b, const Vec<D>& normal, double r_n, double r_t) {
            const auto &p = state_.u[a], &p_old = state_.u_old[a], &q = state_.u[b], &q_old = state_.u_old[b];
            const Vec<D> mean(0.5 * ((p.v[0] + p_old.v[0]) - (q.v[0] + q_old.v[0])),
                              0.5 * ((p.v[1] + p_old.v[1]) - (q.v[1] + q_old.v[1])));
            const double rims = 0.5 * ((p.s[0] + p_old.s[0]) + (q.s[0] + q_old.s[0]));
            const double given = r_n * normal.dot(mean) + r_t * (normal[0] * mean[1] - normal[1] * mean[0] - rims);
            if (given > 0 && given >= found.measure) {
                const Suspect now = suspect(given, a, b);
                found = now.worse_than(found) ? now : found;
            }
        });
    }
    return found;
}

template bool Simulation<2>::may_have_grown(double, const Moved&) const;
template double Simulation<2>::energy_growth(double, int, const StepStart<2>*, EnergyLook);
template Suspect Simulation<2>::driver() const;

} // namespace nappe
