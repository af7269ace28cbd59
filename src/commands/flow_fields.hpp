#pragma once
// The coarse-grained fields and the profiles of one frame, shared among ranks: rows of the grid and bins of the
// profiles are dealt out, each rank gets the grains that its rows or bins see and adds them up in the order of ids. So
// no bit depends on the number of ranks. Rows, not columns: a slab of rows is a slab of the file, and the limits of a
// fault zone are sought along rows.

#include "core/measures/coarse_grain.hpp"
#include "core/measures/surface.hpp"
#include "core/rows.hpp"
#include "io/id_blocks.hpp"

#include <optional>
#include <span>
#include <vector>

namespace nappe {

/// Spacing and range of the fields of a run [m].
struct FieldScales {
    double spacing = 0;
    double range = 0;
};

/// This rank's rows of the fields.
struct FieldSlab {
    FieldGrid grid; ///< the whole one, same on all ranks
    GridRows rows;
    std::vector<FieldNode> nodes; ///< by rows
    std::vector<double> strain;   ///< cumulative shear strain, by rows; NaN outside the material
};

/// The grid around the grains at both of their places, a spacing wider on every side. **Collective over comm.** Throws
/// InputError on all ranks if it has more nodes than a frame has any use for: grains have flown off, or the spacing is
/// too small.
FieldGrid grid_around(const Communicator& comm, const FieldScales& scales, std::span<const FlowGrain> a,
                      std::span<const FlowGrain> b);

/// Fields of grains in blocks of ids. **Collective over comm.**
///
/// @param moving grains where they were in the middle of the interval, with their velocity over it
/// @param seconds length of the interval: each grain's strain grows by it times the shear rate at its place in `moving`
/// @param present the same grains where they are now; their `strain` is updated
FieldSlab coarse_fields(const Communicator& comm, const FieldScales& scales, std::span<const FlowGrain> moving,
                        double seconds, std::span<FlowGrain> present);

/// The profiles of one frame.
struct ProfileSlab {
    Surface surface;        ///< of all bins, same on all ranks
    RowRange bins;          ///< this rank's
    LayerProfiles profiles; ///< of this rank's bins
};

/// Profiles of grains in blocks of ids. **Collective over comm.** Empty if grains lie farther apart than `most_bins`.
ProfileSlab profiles_of(const Communicator& comm, double bin, int n_layers, std::span<const FrameGrain<2>> block);

} // namespace nappe
