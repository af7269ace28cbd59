#include "parallel/domain.hpp"

#include "core/error.hpp"
#include "core/mix.hpp"

#include <algorithm>
#include <array>

namespace nappe {

namespace {

template <int D>
Vec<D> position(const GrainRecord<D>& g) {
    Vec<D> x;
    for (int d = 0; d < D; ++d) {
        x[d] = g.x[d];
    }
    return x;
}

template <class T>
std::vector<T> joined(const std::vector<std::vector<T>>& parts) {
    std::vector<T> all;
    for (const auto& part : parts) {
        all.insert(all.end(), part.begin(), part.end());
    }
    return all;
}

} // namespace

/// Before any contact is known, a tile's work is its grains, and neighbours share what the smaller one has.
template <int D>
void Domain<D>::cut_by_grains(const std::vector<GrainRecord<D>>& grains) {
    std::vector<TileKey> keys;
    keys.reserve(grains.size());
    for (const auto& g : grains) {
        keys.push_back(grid_.key(position(g)));
    }
    std::sort(keys.begin(), keys.end());
    std::vector<TileWork> work;
    for (auto first = keys.begin(); first != keys.end();) {
        const auto last = std::upper_bound(first, keys.end(), *first);
        work.push_back({*first, last - first});
        first = last;
    }
    const auto graph = tile_graph<D>(comm_.all_gather(work), {});
    directory_.assign(graph.keys, partition(graph, comm_.size()));
}

/// Impulses go where their grain goes; they need not have come from the rank that has it. So both are told to a rank
/// that follows from the id, which sends impulses on.
template <int D>
std::vector<ContactRow<D>> Domain<D>::send_after(const std::vector<GrainRecord<D>>& grains,
                                                 const std::vector<ContactRow<D>>& impulses) const {
    struct Place {
        GlobalId id;
        std::int64_t rank;
    };
    const auto n = static_cast<std::size_t>(comm_.size());
    const auto post = [n](GlobalId id) { return mix(static_cast<std::uint64_t>(id)) % n; };
    std::vector<std::vector<Place>> places(n);
    for (const auto& g : grains) {
        places[post(g.id)].push_back({g.id, directory_.owner(grid_.key(position(g)))});
    }
    std::vector<std::vector<ContactRow<D>>> to(n);
    for (const auto& row : impulses) {
        to[post(row.lo)].push_back(row);
    }
    auto homes = joined(comm_.exchange(places));
    std::sort(homes.begin(), homes.end(), [](const Place& p, const Place& q) { return p.id < q.id; });
    const auto arrived = joined(comm_.exchange(to));
    to.assign(n, {});
    for (const auto& row : arrived) {
        const auto home =
            std::lower_bound(homes.begin(), homes.end(), row.lo, [](const Place& p, GlobalId id) { return p.id < id; });
        if (home != homes.end() && home->id == row.lo) { // else an impulse of no grain: nobody will ask for it
            to[static_cast<std::size_t>(home->rank)].push_back(row);
        }
    }
    return joined(comm_.exchange(to));
}

template <int D>
void Domain<D>::distribute(std::vector<GrainRecord<D>> grains, std::vector<ContactRow<D>> impulses,
                           LocalId n_wall_bodies, State<D>& state, ContactMemory<D>& memory) {
    std::string error;
    for (const auto& g : grains) {
        if (!grid_.in_range(position(g))) {
            error = left_the_world(g.id, position(g));
            break;
        }
    }
    comm_.template throw_together<NumericalFailure>(error);
    imbalance_ = 1;
    cut_by_grains(grains);
    memory = {};
    if (comm_.size() == 1) {
        memory.add(std::move(impulses));
    } else {
        memory.add(send_after(grains, impulses));
        std::vector<std::vector<GrainRecord<D>>> to(static_cast<std::size_t>(comm_.size()));
        for (const auto& g : grains) {
            to[static_cast<std::size_t>(directory_.owner(grid_.key(position(g))))].push_back(g);
        }
        grains = joined(comm_.exchange(to));
    }
    sort_by_tile(grains);
    const auto carries = state.carries;
    state = {};
    state.carries = carries;
    state.assign(grains, {}, n_wall_bodies);
    memory.rekey(state);
    list_tiles(state);
    count(state, true);
    range_max_ = comm_.max(widest_reach(state));
    state.complete(fetch_ghosts(state), n_wall_bodies);
}

template <int D>
bool Domain<D>::balance(const std::vector<TileWork>& work, const std::vector<TileLink>& links, const SpentTime& spent) {
    if (comm_.size() == 1) {
        return false;
    }
    std::int64_t mine = 0;
    for (const auto& w : work) {
        mine += w.weight;
    }
    std::array<std::int64_t, 2> sums{mine, static_cast<std::int64_t>(1e9 * spent.relaxing)};
    comm_.sum(sums); // integers: the same on every rank
    const auto largest = comm_.max(mine);
    imbalance_ = sums[0] > 0 ? static_cast<double>(largest) * comm_.size() / static_cast<double>(sums[0]) : 1.0;
    const double per_step =
        1e-9 * static_cast<double>(sums[1]) / comm_.size() / static_cast<double>(spent.steps > 0 ? spent.steps : 1);
    if (!judge_.wants_cut(imbalance_, per_step * balance_.every)) {
        return false;
    }
    const auto graph = tile_graph<D>(comm_.all_gather(work), comm_.all_gather(links));
    const auto part = partition(graph, comm_.size());
    if (!judge_.accepts(nappe::imbalance(graph, part, comm_.size()))) {
        return false;
    }
    directory_.assign(graph.keys, part);
    return true;
}

template class Domain<2>;

} // namespace nappe
