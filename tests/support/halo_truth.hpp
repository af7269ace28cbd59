#pragma once
// What the halo must do, worked out on every rank from a list of all tiles' contacts: no use is made of who asked whom.

#include "core/contact_set.hpp"
#include "parallel/communicator.hpp"
#include "parallel/halo.hpp"

#include <algorithm>
#include <compare>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace nappe::test {

/// A tile has a contact with a grain.
struct Touch {
    std::int32_t colour;
    std::int32_t rank; ///< that owns the tile
    GlobalId grain;
    TileKey tile;
    std::strong_ordering operator<=>(const Touch& o) const {
        if (const auto c = colour <=> o.colour; c != 0) {
            return c;
        }
        if (const auto g = grain <=> o.grain; g != 0) {
            return g;
        }
        return tile <=> o.tile;
    }
    bool operator==(const Touch& o) const { return (*this <=> o) == 0; }
};

struct HaloTruth {
    /// Collective over comm.
    HaloTruth(const Communicator& comm, const State<2>& state, const CandidateSet<2>& candidates) {
        std::vector<Touch> mine;
        for (const auto& tile : candidates.tiles) {
            for (auto c = tile.candidates_begin; c < tile.candidates_end; ++c) {
                for (const LocalId i : {candidates.a[c], candidates.b[c]}) {
                    if (i < state.n_held()) {
                        mine.push_back({tile.colour, comm.rank(), state.id[i], tile.key});
                    }
                }
            }
        }
        touches = comm.all_gather(mine);
        std::sort(touches.begin(), touches.end());
        touches.erase(std::unique(touches.begin(), touches.end()), touches.end());

        struct Held {
            GlobalId grain;
            std::int64_t rank;
        };
        std::vector<Held> held;
        for (const GlobalId id : state.id) {
            held.push_back({id, comm.rank()});
        }
        for (const auto& h : comm.all_gather(held)) {
            holders[h.grain].insert(static_cast<int>(h.rank));
        }
    }

    bool is_interface(TileKey tile) const {
        return std::any_of(touches.begin(), touches.end(),
                           [&](const Touch& t) { return t.tile == tile && holders.at(t.grain).size() > 1; });
    }

    /// What a rank sends in one sweep: v_x, v_y and s of each grain that its tiles of a colour touch, to each other holder.
    HaloTraffic traffic_of(int rank) const {
        std::set<std::pair<int, int>> messages; // colour, receiver
        HaloTraffic traffic;
        for (const auto& t : touches) {
            for (const int to : holders.at(t.grain)) {
                if (t.rank == rank && to != rank) {
                    messages.insert({t.colour, to});
                    traffic.bytes_sent += 3 * static_cast<std::int64_t>(sizeof(double));
                }
            }
        }
        traffic.messages_sent = static_cast<std::int64_t>(messages.size());
        return traffic;
    }

    std::vector<Touch> touches;                ///< of all ranks, each once, by (colour, grain, tile)
    std::map<GlobalId, std::set<int>> holders; ///< ranks with a row for the grain
};

} // namespace nappe::test
