#include "parallel/domain.hpp"

#include "core/error.hpp"
#include "core/mix.hpp"

#include <algorithm>
#include <array>
#include <unordered_map>

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

} // namespace

template <int D>
void Domain<D>::sort_by_tile(std::vector<GrainRecord<D>>& grains) const {
    struct Order {
        TileKey key;
        GlobalId id;
        std::size_t row;
        bool operator<(const Order& o) const { return key != o.key ? key < o.key : id < o.id; }
    };
    std::vector<Order> order(grains.size());
    for (std::size_t i = 0; i < grains.size(); ++i) {
        order[i] = {grid_.key(position(grains[i])), grains[i].id, i};
    }
    if (std::is_sorted(order.begin(), order.end())) {
        return;
    }
    std::sort(order.begin(), order.end());
    std::vector<GrainRecord<D>> sorted(grains.size());
    for (std::size_t i = 0; i < grains.size(); ++i) {
        sorted[i] = grains[order[i].row];
    }
    grains.swap(sorted);
}

template <int D>
void Domain<D>::settle_tiles(const std::vector<GrainRecord<D>>& own) {
    std::string error;
    std::vector<TileKey> fresh;
    for (const auto& g : own) {
        const auto x = position(g);
        if (!grid_.in_range(x)) {
            error = "grain " + std::to_string(g.id) + " left the world: its position " + std::to_string(x[0]) + ", " +
                    std::to_string(x[1]) + " m is beyond what tiles can name; look at its velocity in the last frame";
            break;
        }
        const TileKey key = grid_.key(x);
        if (directory_.owner(key) < 0 && (fresh.empty() || fresh.back() != key)) {
            fresh.push_back(key);
        }
    }
    comm_.template throw_together<NumericalFailure>(error);
    if (comm_.max(static_cast<std::int64_t>(fresh.size())) == 0) {
        return;
    }
    // A tile that several ranks enter at once goes to the lowest of them: all_gather keeps the order of ranks.
    struct Claim {
        TileKey key;
        std::int64_t rank;
    };
    std::vector<Claim> mine;
    for (const TileKey key : fresh) {
        mine.push_back({key, comm_.rank()});
    }
    for (const auto& claim : comm_.all_gather(mine)) {
        directory_.add(claim.key, static_cast<std::int32_t>(claim.rank));
    }
}

template <int D>
void Domain<D>::send_home(std::vector<GrainRecord<D>>& own, std::vector<ContactRow<D>>& impulses) const {
    if (comm_.size() == 1) {
        return;
    }
    const auto n = static_cast<std::size_t>(comm_.size());
    const int me = comm_.rank();
    std::vector<std::vector<GrainRecord<D>>> grains_to(n);
    std::vector<std::vector<ContactRow<D>>> impulses_to(n);
    std::unordered_map<GlobalId, int> leaving;
    std::size_t kept = 0;
    for (const auto& g : own) {
        const int to = directory_.owner(grid_.key(position(g)));
        if (to == me) {
            own[kept++] = g;
        } else {
            grains_to[static_cast<std::size_t>(to)].push_back(g);
            leaving.emplace(g.id, to);
        }
    }
    own.resize(kept);
    kept = 0;
    for (const auto& row : impulses) {
        const auto it = leaving.empty() ? leaving.end() : leaving.find(row.lo);
        if (it == leaving.end()) {
            impulses[kept++] = row;
        } else {
            impulses_to[static_cast<std::size_t>(it->second)].push_back(row);
        }
    }
    impulses.resize(kept);
    if (comm_.max(static_cast<std::int64_t>(leaving.size())) == 0) {
        return;
    }
    for (const auto& part : comm_.exchange(grains_to)) {
        own.insert(own.end(), part.begin(), part.end());
    }
    for (const auto& part : comm_.exchange(impulses_to)) {
        impulses.insert(impulses.end(), part.begin(), part.end());
    }
}

template <int D>
std::vector<GrainRecord<D>> Domain<D>::fetch_ghosts(const std::vector<GrainRecord<D>>& own) {
    double widest = 0;
    for (const auto& g : own) {
        widest = std::max(widest, g.radius + g.margin);
    }
    range_max_ = comm_.max(widest);
    std::vector<GrainRecord<D>> ghosts;
    if (comm_.size() == 1) {
        return ghosts;
    }
    Holders<D> holders(grid_, directory_, comm_.rank());
    std::vector<std::vector<GrainRecord<D>>> to(static_cast<std::size_t>(comm_.size()));
    std::vector<int> ranks;
    for (const auto& g : own) {
        const auto x = position(g);
        holders.find(grid_.key(x), x, g.radius + g.margin + range_max_, ranks);
        for (const int r : ranks) {
            to[static_cast<std::size_t>(r)].push_back(g);
        }
    }
    for (const auto& part : comm_.exchange(to)) {
        ghosts.insert(ghosts.end(), part.begin(), part.end());
    }
    sort_by_tile(ghosts);
    return ghosts;
}

template <int D>
void Domain<D>::count(const std::vector<GrainRecord<D>>& own, bool first) {
    ExactSum mass;
    std::uint64_t check = 0;
    for (const auto& g : own) {
        mass.add(g.mass);
        check += mix(static_cast<std::uint64_t>(g.id));
    }
    const auto n = comm_.sum(static_cast<std::int64_t>(own.size()));
    check = comm_.sum_wrapping(check);
    comm_.sum(mass.limbs());
    if (first) {
        n_grains_ = n;
        id_check_ = check;
        mass_ = mass.value();
        return;
    }
    if (n != n_grains_ || check != id_check_ || mass.value() != mass_) {
        throw SystemError("grains were lost or doubled: " + std::to_string(n) + " of " + std::to_string(n_grains_) +
                          ", ids " + (check == id_check_ ? "complete" : "changed") + ", mass " +
                          std::to_string(mass.value()) + " of " + std::to_string(mass_) +
                          " kg; this is a bug in nappe");
    }
}

template <int D>
void Domain<D>::take(std::vector<GrainRecord<D>> own, std::vector<ContactRow<D>> impulses, LocalId n_wall_bodies,
                     State<D>& state, ContactMemory<D>& memory) {
    settle_tiles(own);
    send_home(own, impulses);
    sort_by_tile(own);
    const auto ghosts = fetch_ghosts(own);
    state.assign(own, ghosts, n_wall_bodies);
    memory = ContactMemory<D>(std::move(impulses));
}

template <int D>
void Domain<D>::distribute(std::vector<GrainRecord<D>> grains, std::vector<ContactRow<D>> impulses,
                           LocalId n_wall_bodies, State<D>& state, ContactMemory<D>& memory) {
    count(grains, true);
    imbalance_ = 1;
    settle_tiles(grains);
    // Before any contact is known, a tile's work is its grains, and neighbours share what the smaller one has.
    std::unordered_map<TileKey, std::int64_t> n_in;
    for (const auto& g : grains) {
        ++n_in[grid_.key(position(g))];
    }
    std::vector<TileWork> work;
    for (const auto& [key, n] : n_in) {
        work.push_back({key, n});
    }
    if (comm_.size() > 1) {
        const auto graph = tile_graph<D>(comm_.all_gather(work), {});
        directory_.assign(graph.keys, partition(graph, comm_.size()));
    }

    // Impulses go where their grain goes; they need not have come from the rank that has it.
    const auto n = static_cast<std::size_t>(comm_.size());
    struct Place {
        GlobalId id;
        std::int64_t rank;
    };
    std::vector<Place> places;
    for (const auto& g : grains) {
        places.push_back({g.id, directory_.owner(grid_.key(position(g)))});
    }
    std::unordered_map<GlobalId, std::int64_t> home;
    for (const auto& p : comm_.all_gather(places)) {
        home.emplace(p.id, p.rank);
    }
    std::vector<std::vector<ContactRow<D>>> to(n);
    for (const auto& row : impulses) {
        to[static_cast<std::size_t>(home.at(row.lo))].push_back(row);
    }
    impulses.clear();
    for (const auto& part : comm_.exchange(to)) {
        impulses.insert(impulses.end(), part.begin(), part.end());
    }
    std::vector<ContactRow<D>> none;
    send_home(grains, none);
    take(std::move(grains), std::move(impulses), n_wall_bodies, state, memory);
}

template <int D>
void Domain<D>::rebuild(State<D>& state, std::vector<ContactRow<D>> impulses, LocalId n_wall_bodies,
                        ContactMemory<D>& memory) {
    std::vector<GrainRecord<D>> own;
    own.reserve(static_cast<std::size_t>(state.n_own));
    for (LocalId i = 0; i < state.n_own; ++i) {
        own.push_back(state.record(i));
    }
    take(std::move(own), std::move(impulses), n_wall_bodies, state, memory);
    own.clear();
    for (LocalId i = 0; i < state.n_own; ++i) {
        own.push_back(state.record(i));
    }
    count(own, false);
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
