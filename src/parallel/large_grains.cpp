#include "parallel/large_grains.hpp"

#include "core/large_grains.hpp"

#include <algorithm>

namespace nappe {

template <int D>
void LargeGrains<D>::find(const Communicator& comm, const State<D>& state) {
    n_ = comm.sum(static_cast<std::int64_t>(large_rows(state).size()));
    places_.clear();
    ranks_.clear();
}

template <int D>
void LargeGrains<D>::gather(const Communicator& comm, const State<D>& state) {
    std::vector<Place> mine;
    for (const LocalId i : large_rows(state)) {
        if (i < state.n_own) {
            Place place{state.id[i], {}, state.reach(i)};
            for (int d = 0; d < D; ++d) {
                place.x[static_cast<std::size_t>(d)] = state.x[i][d];
            }
            mine.push_back(place);
        }
    }
    places_ = comm.all_gather(mine);
}

template <int D>
bool LargeGrains<D>::may_touch(const Vec<D>& x_ref, double reach) const {
    return std::any_of(places_.begin(), places_.end(), [&](const Place& place) {
        Vec<D> x;
        for (int d = 0; d < D; ++d) {
            x[d] = place.x[static_cast<std::size_t>(d)];
        }
        return nappe::may_touch<D>(x_ref, reach, x, place.reach);
    });
}

template <int D>
void LargeGrains<D>::agree(const Communicator& comm, const State<D>& state, std::vector<std::int64_t> holds) {
    const auto rows = large_rows(state);
    if (std::any_of(rows.begin(), rows.end(), [&](LocalId i) { return i < state.n_own; })) {
        holds[static_cast<std::size_t>(comm.rank())] = 1;
    }
    comm.sum(holds);
    ranks_.clear();
    for (std::size_t r = 0; r < holds.size(); ++r) {
        if (holds[r] > 0) {
            ranks_.push_back(static_cast<int>(r));
        }
    }
}

template <int D>
void LargeGrains<D>::share(const Communicator& comm, const State<D>& state, ContactMemory<D>& memory) const {
    std::vector<GlobalId> ids;
    for (const auto& place : places_) {
        ids.push_back(place.id);
    }
    std::sort(ids.begin(), ids.end());
    const auto is_large = [&](GlobalId id) { return std::binary_search(ids.begin(), ids.end(), id); };
    std::vector<ContactRow<D>> mine;
    for (LocalId i = 0; i < state.n_own; ++i) {
        const GlobalId lo = state.id[i];
        const bool of_large = state.is_large(i);
        memory.for_each(i, lo, [&](GlobalId hi, const Impulse<D>& r) {
            if (of_large || is_large(hi)) {
                mine.push_back({lo, hi, r.n, r.t});
            }
        });
    }
    memory.set_of_large(comm.all_gather(mine));
}

template class LargeGrains<2>;

} // namespace nappe
