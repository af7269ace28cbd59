#pragma once
// What a frame says of each of its grains, worked out by all ranks together: every rank for its block of ids.

#include "core/measures/grain_loads.hpp"
#include "io/frame_writer.hpp"

#include <vector>

namespace nappe {

/// Of one grain of this rank's block.
struct GrainFigures {
    GrainLoad<2> load;
    bool rattler = false;
    std::int32_t backbone_contacts = 0;
    double solid_fraction = 0; ///< coarse-grained, at its centre
};

/// One per grain of the block, in the order of ids; the same on any number of ranks. **Collective over comm.**
/// @param range of the coarse-graining kernel [m]
std::vector<GrainFigures> grain_figures(const Communicator& comm, const FrameBlock<2>& frame, double range);

} // namespace nappe
