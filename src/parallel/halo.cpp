#include "parallel/halo.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <unordered_map>

namespace nappe {

namespace {

constexpr int halo_tag = 21;

/// A request to hear of a grain after a colour.
struct Subscription {
    GlobalId id;
    std::int32_t colour;
    std::int32_t padding = 0;
};

} // namespace

template <int D>
void Holders<D>::find(TileKey tile, const Vec<D>& x_ref, double range, std::vector<int>& ranks) {
    ranks.clear();
    if (!known_ || tile != last_) {
        known_ = true;
        last_ = tile;
        ring_ = TileGrid<D>::ring(tile);
        any_ = false;
        for (std::size_t k = 0; k < ring_.size(); ++k) {
            owner_[k] = directory_.owner(ring_[k]);
            any_ = any_ || (owner_[k] >= 0 && owner_[k] != rank_);
        }
    }
    if (!any_) {
        return;
    }
    for (std::size_t k = 0; k < ring_.size(); ++k) {
        if (owner_[k] >= 0 && owner_[k] != rank_ && grid_.distance(x_ref, ring_[k]) <= range) {
            ranks.push_back(owner_[k]);
        }
    }
    std::sort(ranks.begin(), ranks.end());
    ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
}

template <int D>
void Halo<D>::build(const State<D>& state, const TileGrid<D>& grid, const TileDirectory& directory, double range_max,
                    CandidateSet<D>& candidates) {
    for (int c = 0; c < n_tile_colours<D>; ++c) {
        sends_[c].clear();
        receives_[c].clear();
    }
    for (auto& tile : candidates.tiles) {
        tile.interface = false;
    }
    if (comm_.size() == 1) {
        return;
    }

    // Other holders of every held grain, as a CSR table.
    Holders<D> holders(grid, directory, comm_.rank());
    std::vector<std::int32_t> begin(static_cast<std::size_t>(state.n_held()) + 1, 0);
    std::vector<int> all, ranks;
    std::unordered_map<GlobalId, LocalId> row_of; // of the grains that somebody else holds too
    for (LocalId i = 0; i < state.n_held(); ++i) {
        holders.find(grid.key(state.x_ref[i]), state.x_ref[i], state.radius[i] + state.margin[i] + range_max, ranks);
        all.insert(all.end(), ranks.begin(), ranks.end());
        begin[static_cast<std::size_t>(i) + 1] = static_cast<std::int32_t>(all.size());
        if (!ranks.empty()) {
            row_of.emplace(state.id[i], i);
        }
    }

    // What tiles of each colour touch, once per rank, colour and grain.
    const auto n_ranks = static_cast<std::size_t>(comm_.size());
    std::vector<std::vector<Subscription>> told(n_ranks);
    for (auto& tile : candidates.tiles) {
        const auto touch = [&](LocalId i) {
            if (i >= state.n_held()) {
                return;
            }
            for (auto k = begin[i]; k < begin[i + 1]; ++k) {
                told[static_cast<std::size_t>(all[k])].push_back({state.id[i], tile.colour});
                tile.interface = true;
            }
        };
        for (auto c = tile.candidates_begin; c < tile.candidates_end; ++c) {
            touch(candidates.a[c]);
            touch(candidates.b[c]);
        }
    }
    for (auto& list : told) {
        const auto before = [](const auto& p, const auto& q) {
            return p.colour != q.colour ? p.colour < q.colour : p.id < q.id;
        };
        const auto same = [](const auto& p, const auto& q) { return p.colour == q.colour && p.id == q.id; };
        std::sort(list.begin(), list.end(), before);
        list.erase(std::unique(list.begin(), list.end(), same), list.end());
    }
    const auto heard = comm_.exchange(told);

    std::string lost;
    const auto link_up = [&](const std::vector<std::vector<Subscription>>& lists, auto& links) {
        for (std::size_t r = 0; r < n_ranks; ++r) {
            for (const auto& s : lists[r]) {
                auto& of_colour = links[static_cast<std::size_t>(s.colour)];
                if (of_colour.empty() || of_colour.back().rank != static_cast<int>(r)) {
                    of_colour.push_back({static_cast<int>(r), {}, {}});
                }
                const auto it = row_of.find(s.id);
                if (it == row_of.end()) {
                    lost = "halo: grain " + std::to_string(s.id) + " is sent by rank " + std::to_string(r) +
                           " but not held here; this is a bug in nappe";
                    continue;
                }
                of_colour.back().rows.push_back(it->second);
            }
            for (auto& of_colour : links) {
                if (!of_colour.empty() && of_colour.back().rank == static_cast<int>(r)) {
                    of_colour.back().buffer.resize(of_colour.back().rows.size() * n_values);
                }
            }
        }
    };
    link_up(told, sends_);
    link_up(heard, receives_);
    comm_.template throw_together<SystemError>(lost);
}

template <int D>
void Halo<D>::start(int colour, const std::vector<BodyVelocity<D>>& u) {
    requests_.clear();
    arriving_ = &receives_[static_cast<std::size_t>(colour)];
    for (auto& link : *arriving_) {
        MPI_Irecv(link.buffer.data(), static_cast<int>(link.buffer.size()), MPI_DOUBLE, link.rank, halo_tag + colour,
                  comm_.handle(), &requests_.emplace_back());
    }
    for (auto& link : sends_[static_cast<std::size_t>(colour)]) {
        double* out = link.buffer.data();
        for (const LocalId i : link.rows) {
            for (const double v : u[i].v) {
                *out++ = v;
            }
            for (const double s : u[i].s) {
                *out++ = s;
            }
        }
        MPI_Isend(link.buffer.data(), static_cast<int>(link.buffer.size()), MPI_DOUBLE, link.rank, halo_tag + colour,
                  comm_.handle(), &requests_.emplace_back());
        traffic_.messages_sent += 1;
        traffic_.bytes_sent += static_cast<std::int64_t>(link.buffer.size() * sizeof(double));
    }
}

template <int D>
void Halo<D>::finish(std::vector<BodyVelocity<D>>& u) {
    if (requests_.empty()) {
        return;
    }
    MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
    for (const auto& link : *arriving_) {
        const double* in = link.buffer.data();
        for (const LocalId i : link.rows) {
            for (double& v : u[i].v) {
                v = *in++;
            }
            for (double& s : u[i].s) {
                s = *in++;
            }
        }
    }
    requests_.clear();
}

template <int D>
HaloTraffic Halo<D>::per_sweep() const {
    HaloTraffic one;
    for (const auto& links : sends_) {
        for (const auto& link : links) {
            one.messages_sent += 1;
            one.bytes_sent += static_cast<std::int64_t>(link.buffer.size() * sizeof(double));
        }
    }
    return one;
}

template class Holders<2>;
template class Halo<2>;

} // namespace nappe
