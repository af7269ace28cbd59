#pragma once
// Grains strewn at random over a field, every number a function of the id: the same on any number of ranks, and known to
// each rank whole, so that what migration, halo and candidates must give is found here by brute force.

#include "core/mix.hpp"
#include "core/neighbours.hpp"
#include "parallel/domain.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace nappe::test {

inline constexpr double r_max = 0.56; ///< [m]

/// Uniform in [0, 1), from an id and a purpose.
inline double dice(GlobalId id, std::uint64_t purpose) {
    return static_cast<double>(mix(mix(static_cast<std::uint64_t>(id)), purpose) >> 11) * 0x1.0p-53;
}

inline Vec<2> position(const GrainRecord<2>& g) {
    return {g.x[0], g.x[1]};
}

/// n grains in [-30, 90) x [-10, 20) m, overlapping at will; margins up to `largest_margin` [m].
inline std::vector<GrainRecord<2>> strewn_grains(GlobalId n, double largest_margin) {
    std::vector<GrainRecord<2>> grains;
    for (GlobalId id = 0; id < n; ++id) {
        GrainRecord<2> g;
        g.id = id;
        g.x = {-30 + 120 * dice(id, 1), -10 + 30 * dice(id, 2)};
        g.radius = 0.42 + 0.14 * dice(id, 3);
        g.mass = 2800 * 3.14 * g.radius * g.radius;
        g.u.v = {dice(id, 4) - 0.5, dice(id, 5) - 0.5};
        g.u.s = {dice(id, 6) - 0.5};
        g.u.inv_m = 1 / g.mass;
        g.rotation = {dice(id, 7)};
        g.margin = largest_margin * dice(id, 8);
        g.cells = mix(static_cast<std::uint64_t>(id));
        g.material = static_cast<std::int32_t>(id % 3);
        g.layer = static_cast<std::int32_t>(id % 10);
        grains.push_back(g);
    }
    return grains;
}

/// Who has a row before it is spread.
enum class Layout { all_on_first, all_on_last, scattered };
inline constexpr Layout layouts[] = {Layout::all_on_first, Layout::all_on_last, Layout::scattered};

inline int holder_before(Layout layout, GlobalId id, int n_ranks) {
    switch (layout) {
    case Layout::all_on_first:
        return 0;
    case Layout::all_on_last:
        return n_ranks - 1;
    case Layout::scattered:
        break;
    }
    return static_cast<int>(mix(static_cast<std::uint64_t>(id) + 17) % static_cast<std::uint64_t>(n_ranks));
}

/// One to three impulses for every grain, named as contacts are.
inline std::vector<ContactRow<2>> impulses_of(GlobalId id) {
    std::vector<ContactRow<2>> rows;
    for (GlobalId k = 1; k <= 1 + id % 3; ++k) {
        const GlobalId hi = k == 3 ? wall_key + id % 4 : id + k;
        rows.push_back({id, hi, dice(id, 20 + static_cast<std::uint64_t>(k)), {-dice(id, 30)}});
    }
    return rows;
}

inline bool same_bits(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

inline bool same_bits(const GrainRecord<2>& a, const GrainRecord<2>& b) {
    return a.id == b.id && same_bits(a.u.v[0], b.u.v[0]) && same_bits(a.u.v[1], b.u.v[1]) &&
           same_bits(a.u.s[0], b.u.s[0]) && same_bits(a.u.inv_m, b.u.inv_m) && same_bits(a.x[0], b.x[0]) &&
           same_bits(a.x[1], b.x[1]) && same_bits(a.rotation[0], b.rotation[0]) && same_bits(a.radius, b.radius) &&
           same_bits(a.mass, b.mass) && same_bits(a.margin, b.margin) && a.cells == b.cells &&
           a.material == b.material && a.layer == b.layer;
}

/// This rank's own grains as records.
inline std::vector<GrainRecord<2>> own_records(const State<2>& state) {
    std::vector<GrainRecord<2>> own;
    for (LocalId i = 0; i < state.n_own; ++i) {
        own.push_back(state.record(i));
    }
    return own;
}

/// Tiles move at every look that finds an imbalance above this.
inline BalanceSettings always(double threshold) {
    return {threshold, 1, BalanceSettings::By::work, BalanceSettings::Moves::always};
}

/// A domain with its grains spread out.
struct SpreadGrains {
    static constexpr LocalId n_wall_bodies = 4;

    SpreadGrains(const Communicator& comm, std::vector<GrainRecord<2>> grains, double side,
                 Layout layout = Layout::scattered, BalanceSettings balance = always(1.0))
        : all(std::move(grains)), domain(comm, TileGrid<2>(Vec<2>(0.25, -0.5), side), balance) {
        std::vector<GrainRecord<2>> mine;
        std::vector<ContactRow<2>> impulses;
        for (const auto& g : all) {
            if (holder_before(layout, g.id, comm.size()) == comm.rank()) {
                mine.push_back(g);
            }
            // Impulses need not start where their grain does.
            if (holder_before(Layout::scattered, g.id + 1, comm.size()) == comm.rank()) {
                const auto rows = impulses_of(g.id);
                impulses.insert(impulses.end(), rows.begin(), rows.end());
            }
        }
        domain.distribute(mine, impulses, n_wall_bodies, state, memory);
    }

    /// Collective. Every grain goes up to `far` [m] in each direction, on all ranks alike, and the lists are rebuilt.
    void move_all(double far, std::uint64_t round) {
        const auto moved = [&](GlobalId id, double x, std::uint64_t axis) {
            return x + far * (2 * dice(id, 1000 + 10 * round + axis) - 1);
        };
        for (auto& g : all) {
            g.x = {moved(g.id, g.x[0], 0), moved(g.id, g.x[1], 1)};
        }
        for (LocalId i = 0; i < state.n_own; ++i) {
            state.x[i] = {moved(state.id[i], state.x[i][0], 0), moved(state.id[i], state.x[i][1], 1)};
        }
        rebuild();
    }

    void rebuild() {
        memory.rekey(state);
        domain.rebuild(state, n_wall_bodies, memory);
    }

    /// Local. What `memory` has of owned grains.
    std::vector<ContactRow<2>> impulses() const {
        std::vector<ContactRow<2>> rows;
        for (LocalId i = 0; i < state.n_own; ++i) {
            memory.for_each(i, state.id[i], [&](GlobalId hi, const Impulse<2>& r) {
                rows.push_back({state.id[i], hi, r.n, r.t});
            });
        }
        return rows;
    }

    std::vector<GrainRecord<2>> all; ///< what must be there, by id
    State<2> state;
    ContactMemory<2> memory;
    Domain<2> domain;
};

/// Largest margin that tiles of this side allow, as the program has it: the hardest case for halo and colours [m].
inline double margin_for(double side) {
    const Communicator alone(MPI_COMM_SELF);
    return Domain<2>(alone, TileGrid<2>(Vec<2>::Zero(), side), {}).largest_margin(r_max, 0);
}

} // namespace nappe::test
