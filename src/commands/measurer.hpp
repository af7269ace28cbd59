#pragma once
// Measures of a run's frames (docs/measures.md), the same whether they are taken while the run goes on or afterwards
// from its stored frames, and on any number of ranks.

#include "commands/flow_measurer.hpp"
#include "core/measures/clusters.hpp"
#include "core/measures/set_measures.hpp"
#include "core/scene.hpp"
#include "io/frame_writer.hpp"
#include "io/series.hpp"

#include <filesystem>
#include <memory>
#include <vector>

namespace nappe {

class Measurer {
public:
    /// **Collective over comm.** Makes the folder and the series in it; older ones of their names are replaced. Throws
    /// SystemError on all ranks.
    Measurer(const Communicator& comm, const Scene<2>& scene, const std::filesystem::path& folder);
    Measurer(const Measurer&) = delete; // flow_ refers to scene_
    Measurer& operator=(const Measurer&) = delete;
    ~Measurer() = default;

    /// **Collective.** One row in every series. Frames come in the order of time, that of step 0 first: sets of grains
    /// are what they are then. Positions as files have them. Throws InputError if the first is another or empty,
    /// SystemError; on all ranks.
    void measure(FrameBlock<2> frame);

    /// **Collective.** Ends the series. Throws SystemError on all ranks if any row of them could not be written.
    void finish();

    /// Local. Takes away what measures of an older run left in `folder`, so that it does not pass for this one's.
    static void forget(const std::filesystem::path& folder);

private:
    std::vector<SetSums<2>> sum_up(const FrameBlock<2>& frame) const;
    void measure_blocks(const FrameBlock<2>& frame, bool is_first);
    void remember(const FrameBlock<2>& first);
    void share_errors();

    const Communicator& comm_;
    Scene<2> scene_;
    // One per cell of the scene, then that of all grains.
    std::vector<SetReference<2>> references_; ///< empty until the first frame
    std::vector<SeriesWriter> sets_;          ///< on the root only
    std::unique_ptr<SeriesWriter> blocks_;    ///< on the root, if the scene has cohesion
    std::vector<BondedPair> first_bonds_;     ///< of this rank's block in the first frame, by (a, b)
    double range_ = 0;                        ///< of the coarse-graining kernel [m]
    FlowMeasurer flow_;
};

} // namespace nappe
