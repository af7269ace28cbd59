#pragma once
// What moves in a run, measured frame by frame: fields, profiles, the free surface and the fault zone. docs/measures.md
// ("Flow") defines every figure; commands/measurer.hpp calls this, in a run and afterwards alike.

#include "commands/flow_fields.hpp"
#include "core/measures/fault_zone.hpp"
#include "core/measures/trishear.hpp"
#include "core/scene.hpp"
#include "io/frame_writer.hpp"
#include "io/series.hpp"

#include <filesystem>
#include <memory>
#include <span>
#include <vector>

namespace nappe {

/// Writes FOLDER/surface.csv, zone.csv (if the scene has output.zone) and fields/fields-SSSSSSSS.hdf. Every
/// member is **Collective over comm**; all that is written is the same, byte for byte, on any number of ranks.
class FlowMeasurer {
public:
    /// Makes the folders and takes fields of an older run away. Both arguments must outlive the object. Throws
    /// SystemError on all ranks.
    FlowMeasurer(const Communicator& comm, const Scene<2>& scene, std::filesystem::path folder);

    /// Measures one frame; the first is that of step 0, the others follow in the order of time.
    ///
    /// Velocities are displacements since the frame before over the time between, placed halfway, so that fields are
    /// means over the interval; in the first frame they are those of the moment.
    /// @param block this rank's grains, IdBlocks of all, in the order of ids
    /// @param walls where they are now, in the order of Scene::walls
    /// Throws SystemError or InputError on all ranks.
    void measure(std::int64_t step, double time, std::span<const FrameGrain<2>> block,
                 const std::vector<FrameWall<2>>& walls);

    /// Ends the series. Throws SystemError on all ranks if any row of them could not be written.
    void finish();

private:
    void begin(std::span<const FrameGrain<2>> block, const std::vector<FrameWall<2>>& walls);
    void write_fields(std::int64_t step, double time, const FieldSlab& fields, const ProfileSlab& profiles) const;
    std::vector<double> zone_row(const FieldSlab& fields, const Surface& surface, const Vec<2>& drive) const;
    TrishearFit trishear(const FieldSlab& fields, const Surface& surface, const ZoneRule& rule) const;
    Vec<2> drive(double seconds, const std::vector<FrameWall<2>>& walls) const;
    void share_errors() const;

    const Communicator& comm_;
    const Scene<2>& scene_;
    std::filesystem::path folder_;
    std::unique_ptr<SeriesWriter> surface_series_, zone_series_; ///< on the root only

    // From the first frame on.
    FieldScales scales_;
    double bin_ = 0, rise_ = 0, bed_ = 0; ///< of the surface [m]
    int n_layers_ = 0;
    // Of the frame before.
    bool begun_ = false;
    double time_ = 0;
    std::vector<FlowGrain> grains_; ///< this rank's block
    std::vector<FrameWall<2>> walls_;
};

} // namespace nappe
