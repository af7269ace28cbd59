#pragma once
// Writes what a run leaves while it goes on: frames with their index, and the series.

#include "commands/measurer.hpp"
#include "io/frame_writer.hpp"
#include "io/series.hpp"
#include "io/xdmf_index.hpp"
#include "solver/observables.hpp"
#include "solver/simulation.hpp"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace nappe {

class Recorder {
public:
    /// **Collective.** Makes the folders, so that a place that can not be written is known before anything is computed;
    /// takes away what would pass for this run's until it is finished: summary and indices of an older one. Throws
    /// SystemError.
    static void claim(const Communicator& comm, const std::filesystem::path& folder,
                      const std::filesystem::path& samples);

    /// **Collective.** Pre: claim. Throws SystemError.
    Recorder(Simulation<2>& simulation, const std::filesystem::path& folder);

    /// **Collective.** When loading starts: remembers what cells and the bed look like, writes the first row of every
    /// series, and scene.toml.
    void begin();

    /// **Collective.** Whether the series want a row after this loading step, and so the step its residual.
    bool row_due(std::int64_t step) const;

    /// **Collective.** One row in every series, of the interval since the row before.
    void write_row(std::int64_t step, double time);

    /// **Collective.** Throws SystemError on all ranks if it can not be written.
    void write_frame(std::int64_t step, double time);

    /// **Collective.** Ends the series; throws SystemError on all ranks if any row of them could not be written.
    void finish();

    const Overlaps& last_overlaps() const { return overlaps_; }
    double largest_overlap() const { return largest_overlap_; }   ///< of all rows so far
    double largest_residual() const { return largest_residual_; } ///< likewise, 0 before the first step
    int n_frames() const { return n_frames_; }

private:
    struct Series {
        std::vector<SeriesWriter> cells, walls;
        std::unique_ptr<SeriesWriter> front, energy, solver;
    };

    void write_energy(std::int64_t step, double time);
    void write_cells(std::int64_t step, double time, double h);
    void write_walls(std::int64_t step, double time, double h);
    void write_scene();
    void share_errors();

    Simulation<2>& simulation_;
    std::filesystem::path folder_;
    XdmfIndex index_;
    std::optional<Measurer> measurer_; ///< if the scene wants measures during the run
    Series series_;                    ///< on the root only
    std::vector<CellShape<2>> initial_;
    double bed_ = 0;
    double wall_work_ = 0;       ///< since loading started [J]
    double initial_kinetic_ = 0; ///< when loading started [J]
    Overlaps overlaps_;
    double largest_overlap_ = 0;
    double largest_residual_ = 0;
    int n_frames_ = 0;
};

} // namespace nappe
