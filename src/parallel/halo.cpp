#include "parallel/halo.hpp"

#include "core/mix.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <tuple>

namespace nappe {

namespace {

constexpr int halo_tag = 21;
constexpr int tell_tag = halo_tag - 1;

/// What two ranks tell each other about the grains they share starts with a check that they mean the same ones.
using IdCheck = std::uint64_t;

void start_all(std::span<MPI_Request> requests) {
    if (!requests.empty()) { // Open MPI 4.1 aborts on none
        MPI_Startall(static_cast<int>(requests.size()), requests.data());
    }
}

/// value(c) becomes number c of what travels of a body.
template <int D, class Real, class Value>
void put(BodyVelocity<D, Real>& body, Value&& value) {
    for (int c = 0; c < D; ++c) {
        body.v[c] = static_cast<Real>(value(c));
    }
    for (int c = 0; c < n_spin<D>; ++c) {
        body.s[c] = static_cast<Real>(value(D + c));
    }
}

/// u += now - before.
template <int D, class Real>
void add_change(BodyVelocity<D, Real>& body, const double* now, const double* before) {
    put<D>(body, [&](int c) { return (c < D ? body.v[c] : body.s[c - D]) + (now[c] - before[c]); });
}

} // namespace

template <int D>
bool Holders<D>::any_near(TileKey tile) {
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
    return any_;
}

template <int D>
void Holders<D>::find(TileKey tile, const Vec<D>& x_ref, double range, std::vector<int>& ranks) {
    ranks.clear();
    if (!any_near(tile)) {
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
void Holders<D>::find_all(TileKey tile, const Vec<D>& x_ref, const State<D>& state, LocalId i, double range_max,
                          std::vector<int>& ranks) {
    const bool is_large = state.is_large(i);
    if (is_large) {
        ranks.clear();
    } else {
        find(tile, x_ref, state.reach(i) + range_max, ranks);
    }
    if (large_ == nullptr || !large_->any() || !(is_large || large_->may_touch(x_ref, state.reach(i)))) {
        return;
    }
    for (const int r : large_->ranks()) {
        if (r != rank_) {
            ranks.push_back(r);
        }
    }
    std::sort(ranks.begin(), ranks.end());
    ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
}

template <int D>
void Halo<D>::build(const State<D>& state, const TileGrid<D>& grid, const TileDirectory& directory, double range_max,
                    const LargeGrains<D>& large, CandidateSet<D>& candidates) {
    release();
    by_sweep_ = next_by_sweep_;
    for (auto& tile : candidates.tiles) {
        tile.interface = false;
    }
    if (comm_.size() == 1) {
        return;
    }
    find_shared(state, grid, directory, range_max, large, candidates);
    find_neighbours();
    mark_touched(state.n_held(), candidates);
    tell_neighbours();
    lay_out(sends_, &Neighbour::out);
    lay_out(receives_, &Neighbour::in);
    make_requests();
}

/// Requests are kept from one rebuild to the next; what they still send must be out before they go.
template <int D>
void Halo<D>::release() {
    MPI_Waitall(static_cast<int>(sends_.requests.size()), sends_.requests.data(), MPI_STATUSES_IGNORE);
    for (auto* way : {&sends_, &receives_}) {
        for (auto& request : way->requests) {
            MPI_Request_free(&request);
        }
        way->clear();
    }
}

template <int D>
void Halo<D>::find_shared(const State<D>& state, const TileGrid<D>& grid, const TileDirectory& directory,
                          double range_max, const LargeGrains<D>& large, const CandidateSet<D>& candidates) {
    shared_.clear();
    holder_.clear();
    Holders<D> holders(grid, directory, comm_.rank(), large);
    std::vector<int> ranks;
    const auto look_at = [&](TileKey tile, LocalId i) {
        if (state.is_large(i)) {
            return; // every holder moves it alike
        }
        holders.find_all(tile, state.x_ref[i], state, i, range_max, ranks);
        if (!ranks.empty()) {
            const auto begin = static_cast<std::int32_t>(holder_.size());
            holder_.insert(holder_.end(), ranks.begin(), ranks.end());
            shared_.push_back({tile, state.id[i], i, begin, static_cast<std::int32_t>(holder_.size())});
        }
    };
    for (const auto& tile : candidates.plain_tiles()) {
        if (holders.any_near(tile.key) ||
            large.any()) { // else none of its grains need be looked at: most tiles of a large share
            for (LocalId i = tile.grains_begin; i < tile.grains_end; ++i) {
                look_at(tile.key, i);
            }
        }
    }
    for (LocalId i = state.n_own; i < state.n_held(); ++i) {
        look_at(grid.key(state.x_ref[i]), i);
    }
    std::sort(shared_.begin(), shared_.end(),
              [](const Shared& p, const Shared& q) { return std::tie(p.tile, p.id) < std::tie(q.tile, q.id); });
}

template <int D>
void Halo<D>::find_neighbours() {
    auto ranks = holder_;
    std::sort(ranks.begin(), ranks.end());
    ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
    near_.resize(ranks.size());
    for (std::size_t n = 0; n < near_.size(); ++n) {
        near_[n].rank = ranks[n];
        near_[n].common.clear();
    }
    for (std::size_t k = 0; k < shared_.size(); ++k) {
        for (auto h = shared_[k].ranks_begin; h < shared_[k].ranks_end; ++h) {
            const auto n = std::lower_bound(ranks.begin(), ranks.end(), holder_[static_cast<std::size_t>(h)]);
            near_[static_cast<std::size_t>(n - ranks.begin())].common.push_back(static_cast<std::int32_t>(k));
        }
    }
}

template <int D>
void Halo<D>::mark_touched(LocalId n_held, CandidateSet<D>& candidates) {
    touched_.assign(shared_.size(), 0);
    shared_of_row_.assign(static_cast<std::size_t>(n_held), -1);
    std::vector<TileKey> tiles; // that hold shared grains, ascending
    for (std::size_t k = 0; k < shared_.size(); ++k) {
        shared_of_row_[static_cast<std::size_t>(shared_[k].row)] = static_cast<std::int32_t>(k);
        if (tiles.empty() || tiles.back() != shared_[k].tile) {
            tiles.push_back(shared_[k].tile);
        }
    }
    for (auto& tile : candidates.tiles) {
        if (tile.large) {
            continue;
        }
        const auto ring = TileGrid<D>::ring(tile.key);
        if (std::none_of(ring.begin(), ring.end(),
                         [&](TileKey key) { return std::binary_search(tiles.begin(), tiles.end(), key); })) {
            continue;
        }
        const auto bit = static_cast<ColourBits>(by_sweep_ ? 1u : 1u << tile.colour);
        const auto touch = [&](LocalId i) {
            if (i < n_held && shared_of_row_[static_cast<std::size_t>(i)] >= 0) {
                touched_[static_cast<std::size_t>(shared_of_row_[static_cast<std::size_t>(i)])] |= bit;
                tile.interface = true;
            }
        };
        for (auto c = tile.candidates_begin; c < tile.candidates_end; ++c) {
            touch(candidates.a[c]);
            touch(candidates.b[c]);
        }
    }
}

/// Both sides know the grains they share and their order, so a byte for each says all: after which colours to expect it.
template <int D>
void Halo<D>::tell_neighbours() {
    std::vector<MPI_Request> requests;
    for (auto& to : near_) {
        const auto size = sizeof(IdCheck) + to.common.size();
        to.in.resize(size);
        to.out.resize(size);
        IdCheck check = to.common.size();
        for (std::size_t k = 0; k < to.common.size(); ++k) {
            const auto s = static_cast<std::size_t>(to.common[k]);
            check = mix(check, static_cast<std::uint64_t>(shared_[s].id));
            to.out[sizeof(IdCheck) + k] = static_cast<std::byte>(touched_[s]);
        }
        std::memcpy(to.out.data(), &check, sizeof(check));
        MPI_Irecv(to.in.data(), static_cast<int>(size), MPI_BYTE, to.rank, tell_tag, comm_.handle(),
                  &requests.emplace_back());
        MPI_Isend(to.out.data(), static_cast<int>(size), MPI_BYTE, to.rank, tell_tag, comm_.handle(),
                  &requests.emplace_back());
    }
    MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
    for (const auto& from : near_) {
        if (!std::equal(from.in.begin(), from.in.begin() + sizeof(IdCheck), from.out.begin())) {
            // Only this rank may know of it; a halo that is wrong would spoil results without a word.
            std::fprintf(stderr,
                         "halo: ranks %d and %d do not agree on the grains they share; this is a bug in nappe\n",
                         comm_.rank(), from.rank);
            comm_.abort(1);
        }
    }
}

template <int D>
void Halo<D>::lay_out(Way& way, std::vector<std::byte> Neighbour::*told) const {
    for (int colour = 0; colour < n_colours; ++colour) {
        way.first[static_cast<std::size_t>(colour)] = way.rank.size();
        for (const auto& with : near_) {
            const auto before = way.rows.size();
            const std::byte* bits = (with.*told).data() + sizeof(IdCheck);
            for (std::size_t k = 0; k < with.common.size(); ++k) {
                if ((std::to_integer<unsigned>(bits[k]) >> colour & 1u) != 0) {
                    way.rows.push_back(shared_[static_cast<std::size_t>(with.common[k])].row);
                }
            }
            if (way.rows.size() > before) {
                way.rank.push_back(with.rank);
                way.row_begin.push_back(static_cast<std::int32_t>(before));
            }
        }
    }
    way.first.back() = way.rank.size();
    way.row_begin.push_back(static_cast<std::int32_t>(way.rows.size()));
    way.values.resize(way.rows.size() * n_values);
}

template <int D>
void Halo<D>::make_requests() {
    const auto for_each_message = [](Way& way, auto&& make) {
        way.requests.resize(way.rank.size());
        for (int colour = 0; colour < n_colours; ++colour) {
            const auto c = static_cast<std::size_t>(colour);
            for (auto m = way.first[c]; m < way.first[c + 1]; ++m) {
                make(way.values.data() + n_values * way.row_begin[m],
                     n_values * (way.row_begin[m + 1] - way.row_begin[m]), way.rank[m], halo_tag + colour,
                     &way.requests[m]);
            }
        }
    };
    for_each_message(sends_, [&](double* values, int n, int rank, int tag, MPI_Request* request) {
        MPI_Send_init(values, n, MPI_DOUBLE, rank, tag, comm_.handle(), request);
    });
    for_each_message(receives_, [&](double* values, int n, int rank, int tag, MPI_Request* request) {
        MPI_Recv_init(values, n, MPI_DOUBLE, rank, tag, comm_.handle(), request);
    });
}

template <int D>
template <class Real>
void Halo<D>::start(int colour, const std::vector<BodyVelocity<D, Real>>& u) {
    colour_ = colour;
    if (colour == 0) {
        start_all(receives_.requests);
    }
    const auto requests = sends_.requests_of(colour);
    if (requests.empty()) {
        return;
    }
    // Sent in the pass before: out long since, but only now must its buffer be free.
    MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
    double* out = sends_.values_of(colour);
    const auto rows = sends_.rows_of(colour);
    for (const LocalId i : rows) {
        out = std::copy(u[i].v.begin(), u[i].v.end(), out);
        out = std::copy(u[i].s.begin(), u[i].s.end(), out);
    }
    start_all(requests);
    traffic_.messages_sent += static_cast<std::int64_t>(requests.size());
    traffic_.bytes_sent += static_cast<std::int64_t>(rows.size() * n_values * sizeof(double));
}

template <int D>
template <class Real>
void Halo<D>::finish(std::vector<BodyVelocity<D, Real>>& u) {
    const auto requests = receives_.requests_of(colour_);
    if (requests.empty()) {
        return;
    }
    MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
    const double* in = receives_.values_of(colour_);
    for (const LocalId i : receives_.rows_of(colour_)) {
        put<D>(u[i], [&](int k) { return in[k]; });
        in += n_values;
    }
}

template <int D>
template <class Real>
void Halo<D>::open_sweep(const std::vector<BodyVelocity<D, Real>>& u) {
    opened_.resize(shared_.size() * n_values);
    own_.resize(opened_.size());
    double* out = opened_.data();
    for (const auto& grain : shared_) {
        out = std::copy(u[grain.row].v.begin(), u[grain.row].v.end(), out);
        out = std::copy(u[grain.row].s.begin(), u[grain.row].s.end(), out);
    }
}

template <int D>
template <class Real>
void Halo<D>::finish_sweep(std::vector<BodyVelocity<D, Real>>& u) {
    MPI_Waitall(static_cast<int>(receives_.requests.size()), receives_.requests.data(), MPI_STATUSES_IGNORE);
    for (std::size_t k = 0; k < shared_.size(); ++k) {
        auto& of = u[shared_[k].row];
        for (int c = 0; c < n_values; ++c) {
            own_[k * n_values + c] = c < D ? of.v[c] : of.s[c - D];
        }
        put<D>(of, [&](int c) { return opened_[k * n_values + c]; });
    }
    // Messages lie in ascending order of senders.
    bool own_added = false;
    for (std::size_t m = 0; m < receives_.rank.size(); ++m) {
        if (!own_added && receives_.rank[m] > comm_.rank()) {
            add_own_change(u);
            own_added = true;
        }
        for (auto r = receives_.row_begin[m]; r < receives_.row_begin[m + 1]; ++r) {
            const LocalId i = receives_.rows[static_cast<std::size_t>(r)];
            const auto k = static_cast<std::size_t>(shared_of_row_[static_cast<std::size_t>(i)]);
            add_change(u[i], receives_.values.data() + n_values * r, opened_.data() + n_values * k);
        }
    }
    if (!own_added) {
        add_own_change(u);
    }
}

/// Only of grains that own tiles may touch: to add nothing is not nothing, it turns -0 into 0.
template <int D>
template <class Real>
void Halo<D>::add_own_change(std::vector<BodyVelocity<D, Real>>& u) const {
    for (std::size_t k = 0; k < shared_.size(); ++k) {
        if (touched_[k] != 0) {
            add_change(u[shared_[k].row], own_.data() + n_values * k, opened_.data() + n_values * k);
        }
    }
}

template <int D>
HaloTraffic Halo<D>::per_sweep() const {
    return {static_cast<std::int64_t>(sends_.rank.size()),
            static_cast<std::int64_t>(sends_.values.size() * sizeof(double))};
}

template class Holders<2>;
template class Halo<2>;

#define NAPPE_FOR_BODIES(Real) \
    template void Halo<2>::start(int, const std::vector<BodyVelocity<2, Real>>&); \
    template void Halo<2>::finish(std::vector<BodyVelocity<2, Real>>&); \
    template void Halo<2>::open_sweep(const std::vector<BodyVelocity<2, Real>>&); \
    template void Halo<2>::finish_sweep(std::vector<BodyVelocity<2, Real>>&);
NAPPE_FOR_BODIES(double)
NAPPE_FOR_BODIES(float)
#undef NAPPE_FOR_BODIES

} // namespace nappe
