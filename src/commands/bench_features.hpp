#pragma once
// What each feature of a scene adds in bytes and time: one settled pile, stepped with the feature and without it in
// alternating turns.

#include "commands/bench_sample.hpp"
#include "commands/bench_statistics.hpp"

#include <string>
#include <vector>

namespace nappe {

/// A time without the feature and with it, and the ratio of each turn.
struct FeatureTime {
    Quartiles without, with, ratio;

    /// What the feature takes, without what slowed single turns.
    double added() const { return without.median * (ratio.median - 1); }
};

struct FeatureFigures {
    std::string feature;
    std::string kernel;                    ///< variant that sweeps with the feature
    std::int64_t grains = 0, contacts = 0; ///< of all ranks, without the feature
    std::int64_t grain_bytes = 0;          ///< that the feature adds to a grain
    std::int64_t contact_bytes = 0;        ///< and to a contact
    FeatureTime relaxation;                ///< [ns] of one contact and rank
    FeatureTime rest;                      ///< [ns] of a step outside the sweeps, per contact and rank
};

struct FeatureEffort {
    int rounds = 25;
    int steps = 3; ///< of a turn
};

/// The piles that features are added to: settled with the bench's friction, and settled without any, which is at rest
/// with friction too.
struct FeatureBlocks {
    SettledBlock rough, smooth;
};

/// **Collective.** All features that there are, each against what it adds to: friction and a given spin against the pile
/// without friction, all others against the pile with one friction coefficient. Every turn starts from the settled
/// pile, so that its contacts are nearly the same with the feature and without.
std::vector<FeatureFigures> measure_features(const Communicator& comm, const FeatureBlocks& blocks, std::int64_t grains,
                                             const FeatureEffort& effort);

} // namespace nappe
