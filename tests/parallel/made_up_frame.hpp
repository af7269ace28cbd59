#pragma once
// Frames, grains and contacts whose every number follows from ids by a formula, dealt out to the ranks without order:
// what a file must hold is then known without the code under test. tests/e2e/read_frame.py has the same formulas.

#include "io/frame_writer.hpp"

#include <vector>

namespace nappe::test {

inline GrainRow<2> made_up_grain(GlobalId id) {
    GrainRow<2> g;
    const auto k = static_cast<double>(id);
    g.id = id;
    g.x = {k / 3, -k / 7};
    g.v = {0.1 * k, -0.0};
    g.spin = {1 / (k + 1)};
    g.rotation = {-k};
    g.radius = 0.42 + 0.01 * static_cast<double>(id % 15);
    g.mass = 2800 * g.radius * g.radius;
    g.cells = (std::uint64_t{1} << 63) | static_cast<std::uint64_t>(id);
    g.material = static_cast<std::int32_t>(id % 2);
    g.layer = static_cast<std::int32_t>(1 + id % 9);
    return g;
}

/// Grain i touches i + 1 (as far as there is one), and every third one touches a wall.
inline std::vector<ContactRow<2>> made_up_contacts(GlobalId id, GlobalId n) {
    std::vector<ContactRow<2>> rows;
    const auto k = static_cast<double>(id);
    if (id % 3 == 0) {
        rows.push_back({id, wall_key + 2 * id, 5 * k, {0.25}});
    }
    if (id + 1 < n) {
        rows.push_back({id, id + 1, k / 11, {-k / 13}});
    }
    return rows;
}

inline FrameContact<2> as_frame_contact(const ContactRow<2>& row) {
    FrameContact<2> c;
    c.lo = row.lo;
    c.hi = row.hi;
    c.point = {static_cast<double>(row.lo), 0.5};
    c.normal = {0, -1};
    c.gap = -1e-3 * static_cast<double>(row.lo);
    c.r_n = row.r_n;
    c.r_t = row.r_t;
    c.wall = row.hi >= wall_key ? 1 : -1;
    c.status = static_cast<std::int32_t>(row.lo % 3);
    return c;
}

/// This rank's part of n grains. Dealt out by a stride, last first, and nothing at all to the last of several ranks.
inline std::vector<GlobalId> dealt_ids(const Communicator& comm, GlobalId n) {
    const int n_used = comm.size() > 1 ? comm.size() - 1 : 1;
    std::vector<GlobalId> ids;
    for (GlobalId id = n - 1; id >= 0; --id) {
        if ((id * 7) % n_used == comm.rank()) {
            ids.push_back(id);
        }
    }
    return ids;
}

/// with_rank: grains carry the rank that owns them, as in a run; else 0, and files can be compared whole.
inline Frame<2> made_up_frame(const Communicator& comm, GlobalId n, bool with_contacts = true, bool with_rank = true) {
    Frame<2> frame;
    frame.step = 250;
    frame.time = 6.25;
    frame.scene_title = "a fold, made up — in UTF-8";
    for (const GlobalId id : dealt_ids(comm, n)) {
        frame.grains.push_back({made_up_grain(id), 1e3 * static_cast<double>(id), static_cast<std::int32_t>(id % 4),
                                with_rank ? comm.rank() : 0});
        for (const auto& row : made_up_contacts(id, n)) {
            if (with_contacts) {
                frame.contacts.push_back(as_frame_contact(row));
            }
        }
    }
    frame.walls = {{"floor", {{0, 0}, {10, 0}, {10, 5}}}, {"left/wall", {{0, 60}, {0, 0}}}};
    return frame;
}

} // namespace nappe::test
