#pragma once
// `nappe check SCENE`: is the scene sound, and what would running it cost?

#include "core/rows.hpp"
#include "core/scene.hpp"

#include <string>
#include <vector>

namespace nappe {

/// What things cost; the defaults are those of disks with the frictional law.
struct CostModel {
    double ns_per_relaxation = 8;                             ///< of one contact in one sweep on one rank [ns]
    double frame_bytes_per_grain = sizeof(FrameGrain<2>);     ///< on disk
    double frame_bytes_per_contact = sizeof(FrameContact<2>); ///< on disk
};

/// Figures known before anything is computed. All but the exact counts of the scene are estimates.
struct Estimate {
    double grains = 0;
    double contacts = 0;   ///< that touch
    double candidates = 0; ///< pairs kept in the lists
    double memory = 0;     ///< of all ranks together [bytes]
    double loading_steps = 0;
    double relaxations = 0; ///< of the stages with a duration, at their least number of sweeps
    double seconds = 0;     ///< of those on one rank
    double frames = 0;
    double disk = 0; ///< of the frames [bytes]
};

/// Local.
Estimate estimate(const Scene<2>& scene, const CostModel& cost);

/// The summary that `nappe check` prints, for one rank and for `ranks`; its kernel is the fastest of this machine. Local.
std::string describe(const Scene<2>& scene, const CostModel& cost, int ranks);

/// Reads the scene and prints its summary; returns the exit code (0). Local: only one process may run it. Throws
/// InputError.
int check(const std::string& path, const std::vector<std::string>& overrides, const CostModel& cost = {},
          int ranks = 2);

} // namespace nappe
