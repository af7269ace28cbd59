#pragma once
// What a step starts from and what StepStart and the old velocities do not have: all that takes a step back which failed.

#include "core/snapshot.hpp"

#include <optional>
#include <vector>

namespace nappe {

/// Until lists are renewed within the step, what it started from is still there, here and there; just before they are, it
/// is taken down as a whole.
template <int D>
struct Undo {
    bool noted = false;  ///< a step is in hand: what follows is of its start
    bool packed = false; ///< and contacts have been packed since
    SnapshotClock clock;
    std::int64_t relaxations = 0;
    std::vector<Vec<D>> wall_v;
    /// Packing leaves the impulses that a step starts from with their candidates; here they are, by candidate, once others
    /// have been stored there.
    bool kept = false;
    double kept_h = 0; ///< (sub)step that they are of [s]
    std::vector<double> r_n;
    std::vector<std::array<double, D - 1>> r_t;
    std::optional<Snapshot<D>> snapshot;
};

} // namespace nappe
