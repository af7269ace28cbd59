#include "core/passage.hpp"

namespace nappe {

namespace {

/// Squared distance of two centres where it is least, d - s move for s in [0, 1]: d at the end of the way.
template <int D>
double least_squared(const Vec<D>& d, const Vec<D>& move) {
    const double length = move.squaredNorm();
    const double s = length > 0 ? d.dot(move) / length : 0.0;
    const double back = s < 0 ? 0.0 : (s > 1 ? 1.0 : s);
    return (d - back * move).squaredNorm();
}

template <int D>
Vec<D> velocity(const BodyVelocity<D>& u) {
    Vec<D> v;
    for (int d = 0; d < D; ++d) {
        v[d] = u.v[static_cast<std::size_t>(d)];
    }
    return v;
}

template <int D>
bool is_fast(const State<D>& state, LocalId i, double seconds) {
    const double limit = slow_stride * state.radius[static_cast<std::size_t>(i)];
    return seconds * seconds * velocity(state.u_old[static_cast<std::size_t>(i)]).squaredNorm() > limit * limit;
}

} // namespace

template <int D>
Passage find_passage(const State<D>& state, const CandidateSet<D>& candidates, double seconds, bool all) {
    std::vector<char> looked_at(static_cast<std::size_t>(state.n_held()), all ? 1 : 0);
    for (LocalId i = 0; i < state.n_held() && !all; ++i) {
        looked_at[static_cast<std::size_t>(i)] = is_fast(state, i, seconds) ? 1 : 0;
    }
    Passage first;
    for (std::size_t c = 0; c < candidates.a.size(); ++c) {
        const LocalId a = candidates.a[c], b = candidates.b[c];
        if (b >= state.n_held() ||
            (looked_at[static_cast<std::size_t>(a)] | looked_at[static_cast<std::size_t>(b)]) == 0) {
            continue;
        }
        const auto &p = state.mid[static_cast<std::size_t>(a)], &q = state.mid[static_cast<std::size_t>(b)];
        const double larger = p.radius > q.radius ? p.radius : q.radius;
        const Vec<D> d = p.position() - q.position();
        const Vec<D> move = seconds * (velocity(state.u_old[static_cast<std::size_t>(a)]) -
                                       velocity(state.u_old[static_cast<std::size_t>(b)]));
        if (least_squared<D>(d, move) < larger * larger) {
            const GlobalId lo = state.id[static_cast<std::size_t>(a)], hi = state.id[static_cast<std::size_t>(b)];
            if (lo < first.lo || (lo == first.lo && hi < first.hi)) {
                first = {lo, hi, -1};
            }
        }
    }
    return first;
}

template <int D>
Passage find_wall_passage(const State<D>& state, const CandidateSet<D>& candidates, const Walls<D>& walls,
                          std::span<const std::size_t> tiles, double seconds) {
    Passage first;
    for (const std::size_t t : tiles) {
        const auto& tile = candidates.tiles[t];
        for (auto c = static_cast<std::size_t>(tile.candidates_begin);
             c < static_cast<std::size_t>(tile.candidates_end); ++c) {
            const LocalId a = candidates.a[c], b = candidates.b[c];
            if (b < state.n_held() || state.id[static_cast<std::size_t>(a)] >= first.lo) {
                continue;
            }
            const int sided = b - state.n_held();
            const Vec<D> move = seconds * (velocity(state.u[static_cast<std::size_t>(a)]) -
                                           velocity(state.u[static_cast<std::size_t>(b)]));
            if (walls.crossed(sided, state.mid[static_cast<std::size_t>(a)].position() + move, move)) {
                first = {state.id[static_cast<std::size_t>(a)], Passage::none, walls.feature(sided).wall};
            }
        }
    }
    return first;
}

template Passage find_passage(const State<2>&, const CandidateSet<2>&, double, bool);
template Passage find_wall_passage(const State<2>&, const CandidateSet<2>&, const Walls<2>&,
                                   std::span<const std::size_t>, double);

} // namespace nappe
