#include "solver/observables.hpp"

#include "core/contact_geometry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace nappe {

template <int D>
Energies energies(const Simulation<D>& simulation) {
    const auto& state = simulation.state();
    ExactSum kinetic, potential;
    for (const auto& tile : simulation.candidates().tiles) {
        double k = 0, p = 0;
        for (auto i = tile.grains_begin; i < tile.grains_end; ++i) {
            k += kinetic_energy(state.u[i], state.mass[i]);
            p -= state.mass[i] * simulation.scene().gravity.dot(state.x[i]);
        }
        kinetic.add(k);
        potential.add(p);
    }
    simulation.comm().sum(kinetic.limbs());
    simulation.comm().sum(potential.limbs());
    return {kinetic.value(), potential.value()};
}

template <int D>
Overlaps overlaps(const Simulation<D>& simulation) {
    const auto& state = simulation.state();
    const auto& set = simulation.candidates();
    ExactSum sum;
    Overlaps o;
    for (const auto& tile : set.counted_tiles()) {
        double of_tile = 0;
        for (auto c = tile.candidates_begin; c < tile.candidates_end; ++c) {
            const LocalId a = set.a[c], b = set.b[c];
            const auto g = contact_geometry(state, simulation.walls(), a, b);
            if (!g.applies) {
                continue;
            }
            const double r_b = b < state.n_held() ? state.radius[b] : state.radius[a];
            const double smaller = state.radius[a] < r_b ? state.radius[a] : r_b;
            const double overlap = g.gap < 0 ? -g.gap / smaller : 0.0;
            o.largest = overlap > o.largest ? overlap : o.largest;
            if (set.r_n[c] != 0) {
                of_tile += overlap;
                ++o.contacts;
            }
        }
        sum.add(of_tile);
    }
    const auto& comm = simulation.comm();
    comm.sum(sum.limbs());
    o.largest = comm.max(o.largest);
    o.contacts = comm.sum(o.contacts);
    const auto counted = set.counted_tiles();
    o.candidates = comm.sum(static_cast<std::int64_t>(counted.empty() ? 0 : counted.back().candidates_end));
    o.mean = o.contacts > 0 ? sum.value() / static_cast<double>(o.contacts) : 0.0;
    return o;
}

template <int D>
std::vector<CellShape<D>> cell_shapes(const Simulation<D>& simulation) {
    const auto& state = simulation.state();
    const std::size_t n = simulation.scene().output.cells.size();
    constexpr double none = -std::numeric_limits<double>::infinity();
    std::vector<double> reach(n * 2 * D, none); // largest x, largest -x, …
    std::vector<std::int64_t> count(n, 0);
    std::vector<ExactSum> volume(n);
    for (LocalId i = 0; i < state.n_own; ++i) {
        auto bits = state.cells_of(i);
        for (std::size_t k = 0; bits != 0; ++k, bits >>= 1) {
            if ((bits & 1) == 0) {
                continue;
            }
            ++count[k];
            volume[k].add(std::numbers::pi * state.radius[i] * state.radius[i]);
            for (int d = 0; d < D; ++d) {
                double* extreme = &reach[2 * (k * D + static_cast<std::size_t>(d))];
                extreme[0] = std::max(extreme[0], state.x[i][d]);
                extreme[1] = std::max(extreme[1], -state.x[i][d]);
            }
        }
    }
    const auto& comm = simulation.comm();
    if (n > 0) {
        comm.max(std::span(reach));
        comm.sum(std::span(count));
    }
    std::vector<CellShape<D>> shapes(n);
    for (std::size_t k = 0; k < n; ++k) {
        comm.sum(volume[k].limbs());
        shapes[k].grains = count[k];
        shapes[k].volume = volume[k].value();
        for (int d = 0; d < D && count[k] > 0; ++d) {
            const double* extreme = &reach[2 * (k * D + static_cast<std::size_t>(d))];
            shapes[k].extent[d] = extreme[0] + extreme[1];
        }
    }
    return shapes;
}

template <int D>
Surface free_surface(const Simulation<D>& simulation, double bin) {
    const auto& state = simulation.state();
    constexpr std::int64_t none = std::numeric_limits<std::int64_t>::min();
    std::int64_t last = none, first_negated = none;
    for (LocalId i = 0; i < state.n_own; ++i) {
        last = std::max(last, bin_of(state.x[i][0], bin));
        first_negated = std::max(first_negated, -bin_of(state.x[i][0], bin));
    }
    const auto& comm = simulation.comm();
    last = comm.max(last);
    first_negated = comm.max(first_negated);
    Surface surface = empty_surface(bin, last == none ? 0 : -first_negated, last);
    if (surface.height.empty()) {
        return surface;
    }
    for (LocalId i = 0; i < state.n_own; ++i) {
        raise_surface(surface, state.x[i][0], state.x[i][1] + state.radius[i]);
    }
    comm.max(std::span(surface.height));
    return surface;
}

template <int D>
std::vector<FrameGrain<D>> frame_grains(const Simulation<D>& simulation) {
    struct Load {
        GlobalId grain, partner;
        double r_n;
    };
    const auto& state = simulation.state();
    const auto& set = simulation.candidates();
    const auto& comm = simulation.comm();
    std::vector<std::vector<Load>> to(static_cast<std::size_t>(comm.size()));
    for (std::size_t c = 0; c < set.a.size(); ++c) {
        const LocalId a = set.a[c], b = set.b[c];
        if (set.r_n[c] == 0 || a >= state.n_own) {
            continue;
        }
        to[static_cast<std::size_t>(comm.rank())].push_back({state.id[a], partner_key(state, b), set.r_n[c]});
        if (b < state.n_held()) {
            const int owner =
                b < state.n_own ? comm.rank()
                                : simulation.domain().directory().owner(simulation.domain().grid().key(state.x_ref[b]));
            to[static_cast<std::size_t>(owner)].push_back({state.id[b], state.id[a], set.r_n[c]});
        }
    }
    std::vector<Load> loads;
    for (const auto& part : comm.exchange(to)) {
        loads.insert(loads.end(), part.begin(), part.end());
    }
    std::sort(loads.begin(), loads.end(), [](const Load& p, const Load& q) {
        return p.grain != q.grain ? p.grain < q.grain : p.partner < q.partner;
    });

    std::vector<FrameGrain<D>> rows(static_cast<std::size_t>(state.n_own));
    const double h = simulation.settings().h / simulation.settings().substeps;
    for (LocalId i = 0; i < state.n_own; ++i) {
        auto& row = rows[static_cast<std::size_t>(i)];
        row.grain = to_row(state.record(i));
        row.rank = comm.rank();
        const auto before = [](const Load& l, GlobalId id) { return l.grain < id; };
        double sum = 0;
        for (auto l = std::lower_bound(loads.begin(), loads.end(), state.id[i], before);
             l != loads.end() && l->grain == state.id[i]; ++l) {
            sum += l->r_n;
            ++row.coordination;
        }
        // (1/V) tr(sum f ⊗ r n) / 2 over the disk's own area.
        row.pressure = sum / h / (2 * std::numbers::pi * state.radius[i]);
    }
    return rows;
}

template <int D>
std::vector<FrameContact<D>> frame_contacts(const Simulation<D>& simulation) {
    const auto& state = simulation.state();
    const auto& set = simulation.candidates();
    const auto& walls = simulation.walls();
    const double h = simulation.settings().h / simulation.settings().substeps;
    std::vector<FrameContact<D>> rows;
    for (std::size_t c = 0; c < set.a.size(); ++c) {
        const LocalId a = set.a[c], b = set.b[c];
        if (a >= state.n_own) {
            continue;
        }
        const auto g = contact_geometry(state, walls, a, b);
        const auto* law = find_law(simulation.scene(), state.material[a], state.material[b]);
        const bool cohesive = simulation.contacts().cohesive() && law != nullptr && law->gamma > 0;
        const Bond bond = cohesive ? bond_at(g.gap, law->d_w) : Bond::none;
        if (!g.applies || (set.r_n[c] == 0 && g.gap > 0 && bond == Bond::none)) {
            continue;
        }
        FrameContact<D> row;
        row.lo = state.id[a];
        row.hi = partner_key(state, b);
        row.gap = g.gap;
        row.r_n = set.r_n[c];
        row.r_t = set.impulse(c).t;
        double tangential = 0;
        for (int d = 0; d < D; ++d) {
            row.normal[d] = g.n[d];
            row.point[d] = state.x[a][d] - (state.radius[a] + 0.5 * g.gap) * g.n[d];
        }
        for (const double t : row.r_t) {
            tangential += t * t;
        }
        const bool wall = b >= state.n_held();
        row.wall = wall ? walls.feature(b - state.n_held()).wall : -1;
        // What friction had to hold against in the step: the bond was that of its start.
        const bool held = cohesive && !set.bond.empty() && set.bond[c] != Bond::none;
        const double pressed = row.r_n + (held ? h * law->gamma : 0.0);
        const double limit = (law != nullptr ? law->friction : 0.0) * pressed;
        row.bond = static_cast<std::int32_t>(bond);
        const auto status = !(pressed > 0)                                ? ContactStatus::open
                            : std::sqrt(tangential) < limit * (1 - 1e-12) ? ContactStatus::stick
                                                                          : ContactStatus::slip;
        row.status = static_cast<std::int32_t>(status);
        rows.push_back(row);
    }
    return rows;
}

template Energies energies(const Simulation<2>&);
template Overlaps overlaps(const Simulation<2>&);
template std::vector<CellShape<2>> cell_shapes(const Simulation<2>&);
template Surface free_surface(const Simulation<2>&, double);
template std::vector<FrameGrain<2>> frame_grains(const Simulation<2>&);
template std::vector<FrameContact<2>> frame_contacts(const Simulation<2>&);

} // namespace nappe
