#pragma once
// What rows of a stored file must obey before anything is computed with them. Checksums say that they are what was written;
// these rules, that what was written is a state of this scene: a broken one would be an index out of range or a NaN later.
// Everything here is Local: a rank checks its part, and the ranks agree on the reason (read_stored).

#include "core/rows.hpp"
#include "core/scene.hpp"
#include "core/snapshot.hpp"

#include <limits>
#include <span>
#include <string>

namespace nappe {

/// What rows may refer to. As made: anything that a scene might hold.
struct RowLimits {
    std::int32_t n_materials = std::numeric_limits<std::int32_t>::max();
    double smallest_radius = 0;                                 ///< [m]
    double largest_radius = std::numeric_limits<double>::max(); ///< [m]; tiles are as wide as it needs
    double tile_side = 0; ///< [m]; places are within the grid of such tiles; 0: any
    std::int64_t n_wall_bodies =
        std::numeric_limits<std::int64_t>::max() - wall_key; ///< sided features (core/walls.hpp)
};

/// Those of a scene's grains and walls.
template <int D>
RowLimits row_limits(const Scene<D>& scene);

/// The first rule that the grains break, with its grain and the value found, or "": ids first, first + 1 …; places,
/// velocities, spins and rotations are numbers; radius and mass are > 0 and numbers; radius and material are the scene's.
template <int D>
std::string broken_rule(std::span<const GrainRow<D>> grains, GlobalId first, const RowLimits& limits);

/// Likewise of the contacts of the grains [first, first + count) of n_grains: sorted by (lo, hi), no pair twice, lo < hi,
/// both there, impulses are numbers.
template <int D>
std::string broken_rule(std::span<const ContactRow<D>> contacts, GlobalId first, std::int64_t count,
                        std::int64_t n_grains, const RowLimits& limits);

/// Likewise of a snapshot, whose grains are a block of ids, for this scene: grains (also where they stood at the last
/// rebuild) and contacts as above; as many walls as the scene has, at numbers; a stage that the scene has; counts >= 0.
template <int D>
std::string broken_rule(const Snapshot<D>& snapshot, const Scene<D>& scene, GlobalId first, std::int64_t n_grains);

} // namespace nappe
