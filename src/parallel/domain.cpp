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

template <int D>
void Domain<D>::own_as(const std::vector<TileOwner>& owners) {
    std::vector<TileKey> keys;
    std::vector<std::int32_t> ranks;
    for (const auto& owner : owners) {
        keys.push_back(owner.key);
        ranks.push_back(static_cast<std::int32_t>(owner.rank));
    }
    directory_.assign(keys, ranks);
}

/// Whoever has a place tells a rank that follows from the id, and whoever holds the grain asks that rank.
template <int D>
void Domain<D>::place(const std::vector<PlacedGrain<D>>& places, State<D>& state) const {
    const auto n = static_cast<std::size_t>(comm_.size());
    const auto post = [n](GlobalId id) { return mix(static_cast<std::uint64_t>(id)) % n; };
    std::vector<std::vector<PlacedGrain<D>>> told(n);
    for (const auto& place : places) {
        told[post(place.id)].push_back(place);
    }
    std::vector<std::vector<GlobalId>> asked(n);
    for (const GlobalId id : state.id) {
        asked[post(id)].push_back(id);
    }
    auto known = joined(comm_.exchange(told));
    std::sort(known.begin(), known.end(), [](const auto& p, const auto& q) { return p.id < q.id; });
    const auto questions = comm_.exchange(asked);
    std::vector<std::vector<PlacedGrain<D>>> answers(n);
    std::string error;
    for (std::size_t r = 0; r < n; ++r) {
        for (const GlobalId id : questions[r]) {
            const auto at = std::lower_bound(known.begin(), known.end(), id,
                                             [](const PlacedGrain<D>& p, GlobalId wanted) { return p.id < wanted; });
            if (at == known.end() || at->id != id) {
                error = "grain " + std::to_string(id) + " has no place: a bug of nappe";
                continue;
            }
            answers[r].push_back(*at);
        }
    }
    comm_.template throw_together<SystemError>(error);
    const auto answered = comm_.exchange(answers);
    std::vector<std::size_t> next(n, 0); // answers come in the order of questions
    for (LocalId i = 0; i < state.n_held(); ++i) {
        const auto r = post(state.id[i]);
        const auto& place = answered[r][next[r]++];
        for (int d = 0; d < D; ++d) {
            state.x[i][d] = place.x[static_cast<std::size_t>(d)];
            state.mid[i].x[d] = state.x[i][d];
        }
    }
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
                           LocalId n_wall_bodies, State<D>& state, ContactMemory<D>& memory,
                           const std::vector<TileOwner>& owners) {
    std::string error;
    for (const auto& g : grains) {
        if (!grid_.in_range(position(g))) {
            error = left_the_world(g.id, position(g));
            break;
        }
    }
    comm_.template throw_together<NumericalFailure>(error);
    imbalance_ = 1;
    owners.empty() ? cut_by_grains(grains) : own_as(owners);
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
    const double attraction = state.attraction, large_above = state.large_above;
    state = {};
    state.carries = carries;
    state.attraction = attraction;
    state.large_above = large_above;
    state.assign(grains, {}, n_wall_bodies);
    memory.rekey(state);
    list_tiles(state);
    count(state, true);
    large_.find(comm_, state);
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
