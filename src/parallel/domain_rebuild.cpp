// What changes hands at a rebuild. Most grains stay in their tile and most tiles with their rank: rows of those keep their
// order, and only the others are sorted, sent and merged in.

#include "core/error.hpp"
#include "core/mix.hpp"
#include "parallel/domain.hpp"

#include <algorithm>
#include <array>

namespace nappe {

template <int D>
std::string Domain<D>::left_the_world(GlobalId id, const Vec<D>& x) {
    return "grain " + std::to_string(id) + " left the world: its position " + std::to_string(x[0]) + ", " +
           std::to_string(x[1]) + " m is beyond what tiles can name; look at its velocity in the last frame";
}

template <int D>
void Domain<D>::sort_by_tile(std::vector<GrainRecord<D>>& grains) const {
    std::vector<Mover> order(grains.size());
    for (std::size_t i = 0; i < grains.size(); ++i) {
        Vec<D> x;
        for (int d = 0; d < D; ++d) {
            x[d] = grains[i].x[d];
        }
        order[i] = {grid_.key(x), grains[i].id, static_cast<LocalId>(i)};
    }
    if (std::is_sorted(order.begin(), order.end())) {
        return;
    }
    std::sort(order.begin(), order.end());
    std::vector<GrainRecord<D>> sorted(grains.size());
    for (std::size_t i = 0; i < grains.size(); ++i) {
        sorted[i] = grains[static_cast<std::size_t>(order[i].row)];
    }
    grains.swap(sorted);
}

template <int D>
void Domain<D>::list_tiles(const State<D>& state) {
    own_tiles_.clear();
    for (LocalId i = 0; i < state.n_own; ++i) {
        const TileKey key = grid_.key(state.x[i]);
        if (own_tiles_.empty() || own_tiles_.back().key != key) {
            own_tiles_.push_back({key, i, i});
        }
        own_tiles_.back().end = i + 1;
    }
}

/// In the order of rows.
template <int D>
std::vector<typename Domain<D>::Mover> Domain<D>::find_movers(const State<D>& state) const {
    std::vector<Mover> movers;
    for (const auto& tile : own_tiles_) {
        const bool mine = directory_.owner(tile.key) == comm_.rank();
        for (LocalId i = tile.begin; i < tile.end; ++i) {
            const TileKey key = grid_.in_range(state.x[i]) ? grid_.key(state.x[i]) : nowhere;
            if (key != tile.key || !mine) {
                movers.push_back({key, state.id[i], i});
            }
        }
    }
    return movers;
}

/// Largest reach of owned grains, large ones left out [m].
template <int D>
double Domain<D>::widest_reach(const State<D>& state) {
    double widest = 0;
    for (LocalId i = 0; i < state.n_own; ++i) {
        const double reach = state.reach(i);
        widest = reach > widest && !state.is_large(i) ? reach : widest;
    }
    return widest;
}

/// Gives tiles in which no grain has been to ranks; returns whether any grain of any rank goes to another.
template <int D>
bool Domain<D>::settle_tiles(const State<D>& state, const std::vector<Mover>& movers) {
    std::vector<TileKey> fresh;
    GlobalId lost = -1;
    bool leaving = false;
    for (const auto& mover : movers) {
        if (mover.key == nowhere) {
            lost = mover.id;
            continue;
        }
        const auto owner = directory_.owner(mover.key);
        if (owner < 0) {
            fresh.push_back(mover.key);
        }
        leaving = leaving || (owner >= 0 && owner != comm_.rank());
    }
    // One reduction for all that must be known: errors, new tiles, grains that leave, the largest reach.
    std::array<double, 4> most{lost >= 0 ? 1.0 : 0.0, static_cast<double>(fresh.size()), leaving ? 1.0 : 0.0,
                               widest_reach(state)};
    comm_.max(most);
    range_max_ = most[3];
    if (most[0] > 0) {
        std::string error;
        for (LocalId i = 0; i < state.n_own && error.empty(); ++i) {
            error = state.id[i] == lost ? left_the_world(lost, state.x[i]) : std::string();
        }
        comm_.template throw_together<NumericalFailure>(error);
    }
    if (most[1] > 0) {
        // A tile that several ranks enter at once goes to the lowest of them: all_gather keeps the order of ranks.
        struct Claim {
            TileKey key;
            std::int64_t rank;
        };
        std::vector<Claim> mine;
        mine.reserve(fresh.size());
        for (const TileKey key : fresh) {
            mine.push_back({key, comm_.rank()});
        }
        for (const auto& claim : comm_.all_gather(mine)) {
            directory_.add(claim.key, static_cast<std::int32_t>(claim.rank));
        }
    }
    return most[1] > 0 || most[2] > 0;
}

/// Sends away what goes to other ranks, with its impulses; `movers` keeps those that stay and gets those that come.
template <int D>
std::vector<GrainRecord<D>> Domain<D>::migrate(const State<D>& state, std::vector<Mover>& movers,
                                               ContactMemory<D>& memory) {
    const auto n = static_cast<std::size_t>(comm_.size());
    std::vector<std::vector<GrainRecord<D>>> grains_to(n);
    std::vector<std::vector<ContactRow<D>>> impulses_to(n);
    std::size_t kept = 0;
    for (const auto& mover : movers) {
        const auto to = directory_.owner(mover.key);
        if (to == comm_.rank()) {
            movers[kept++] = mover;
            continue;
        }
        grains_to[static_cast<std::size_t>(to)].push_back(state.record(mover.row));
        memory.for_each(mover.row, mover.id, [&](GlobalId hi, const Impulse<D>& r) {
            impulses_to[static_cast<std::size_t>(to)].push_back({mover.id, hi, r.n, r.t});
        });
    }
    movers.resize(kept);
    std::vector<GrainRecord<D>> arrivals;
    for (const auto& part : comm_.exchange(grains_to)) {
        arrivals.insert(arrivals.end(), part.begin(), part.end());
    }
    for (std::size_t k = 0; k < arrivals.size(); ++k) {
        Vec<D> x;
        for (int d = 0; d < D; ++d) {
            x[d] = arrivals[k].x[d];
        }
        movers.push_back({grid_.key(x), arrivals[k].id, -1 - static_cast<LocalId>(k)});
    }
    std::vector<ContactRow<D>> impulses;
    for (const auto& part : comm_.exchange(impulses_to)) {
        impulses.insert(impulses.end(), part.begin(), part.end());
    }
    memory.add(std::move(impulses));
    return arrivals;
}

/// Rows in their new order, as what they were: those that stay, less `gone` (by row), with `here` merged in.
template <int D>
std::vector<LocalId> Domain<D>::merge_rows(const State<D>& state, const std::vector<Mover>& gone,
                                           std::vector<Mover> here) {
    std::sort(here.begin(), here.end());
    std::vector<LocalId> from;
    from.reserve(static_cast<std::size_t>(state.n_own));
    std::vector<Span> tiles;
    auto next_gone = gone.begin();
    auto mover = here.begin();
    const auto put = [&](TileKey key, LocalId row) {
        const auto i = static_cast<LocalId>(from.size());
        if (tiles.empty() || tiles.back().key != key) {
            tiles.push_back({key, i, i});
        }
        tiles.back().end = i + 1;
        from.push_back(row);
    };
    for (const auto& tile : own_tiles_) {
        for (; mover != here.end() && mover->key < tile.key; ++mover) {
            put(mover->key, mover->row);
        }
        for (LocalId i = tile.begin; i < tile.end; ++i) {
            if (next_gone != gone.end() && next_gone->row == i) {
                ++next_gone;
                continue;
            }
            for (; mover != here.end() && mover->key == tile.key && mover->id < state.id[i]; ++mover) {
                put(mover->key, mover->row);
            }
            put(tile.key, i);
        }
    }
    for (; mover != here.end(); ++mover) {
        put(mover->key, mover->row);
    }
    own_tiles_.swap(tiles);
    return from;
}

/// Who takes part in the contacts of large grains. Rows are as they will be, x_ref = x.
template <int D>
void Domain<D>::find_holders_of_large(const State<D>& state) {
    large_.gather(comm_, state);
    std::vector<std::int64_t> holds(static_cast<std::size_t>(comm_.size()), 0);
    Holders<D> holders(grid_, directory_, comm_.rank());
    std::vector<int> ranks;
    for (const auto& tile : own_tiles_) {
        for (LocalId i = tile.begin; i < tile.end; ++i) {
            if (!state.is_large(i) && large_.may_touch(state.x[i], state.reach(i))) {
                holds[static_cast<std::size_t>(comm_.rank())] = 1;
                holders.find(tile.key, state.x[i], state.reach(i) + range_max_, ranks);
                for (const int r : ranks) {
                    holds[static_cast<std::size_t>(r)] = 1;
                }
            }
        }
    }
    large_.agree(comm_, state, std::move(holds));
}

template <int D>
std::vector<GrainRecord<D>> Domain<D>::fetch_ghosts(const State<D>& state) {
    std::vector<GrainRecord<D>> ghosts;
    if (large_.any()) {
        find_holders_of_large(state);
    }
    if (comm_.size() == 1) {
        return ghosts;
    }
    Holders<D> holders(grid_, directory_, comm_.rank(), large_);
    std::vector<std::vector<GrainRecord<D>>> to(static_cast<std::size_t>(comm_.size()));
    std::vector<int> ranks;
    for (const auto& tile : own_tiles_) {
        if (!holders.any_near(tile.key) && !large_.any()) {
            continue;
        }
        for (LocalId i = tile.begin; i < tile.end; ++i) {
            holders.find_all(tile.key, state.x[i], state, i, range_max_, ranks);
            for (const int r : ranks) {
                to[static_cast<std::size_t>(r)].push_back(state.record(i));
            }
        }
    }
    for (const auto& part : comm_.exchange(to)) {
        ghosts.insert(ghosts.end(), part.begin(), part.end());
    }
    sort_by_tile(ghosts);
    return ghosts;
}

template <int D>
void Domain<D>::count(const State<D>& state, bool first) {
    ExactSum mass;
    std::uint64_t check = 0;
    for (LocalId i = 0; i < state.n_own; ++i) {
        mass.add(state.mass[i]);
        check += mix(static_cast<std::uint64_t>(state.id[i]));
    }
    // One reduction: integers wrap alike on all ranks.
    std::vector<std::int64_t> sums(mass.limbs().begin(), mass.limbs().end());
    sums.push_back(state.n_own);
    sums.push_back(static_cast<std::int64_t>(check));
    comm_.sum(sums);
    const auto n = sums[sums.size() - 2];
    check = static_cast<std::uint64_t>(sums.back());
    std::copy_n(sums.begin(), mass.limbs().size(), mass.limbs().begin());
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
void Domain<D>::rebuild(State<D>& state, LocalId n_wall_bodies, ContactMemory<D>& memory) {
    if ((own_tiles_.empty() ? 0 : own_tiles_.back().end) != state.n_own) {
        list_tiles(state); // grains came or went by another way: the count below says so
    }
    auto here = find_movers(state);
    const auto gone = here;
    std::vector<GrainRecord<D>> arrivals;
    if (settle_tiles(state, here)) {
        arrivals = migrate(state, here, memory);
    }
    auto from = merge_rows(state, gone, std::move(here));
    state.reorder(from, arrivals);
    memory.rows_moved(std::move(from));
    state.complete(fetch_ghosts(state), n_wall_bodies);
    if (large_.any()) {
        large_.share(comm_, state, memory);
    }
    count(state, false);
}

template class Domain<2>;

} // namespace nappe
