#pragma once
// Writes what a run leaves while it goes on: frames with their index, and the series.

#include "commands/measurer.hpp"
#include "commands/sensors.hpp"
#include "io/frame_writer.hpp"
#include "io/series.hpp"
#include "io/xdmf_index.hpp"
#include "solver/observables.hpp"
#include "solver/simulation.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace nappe {

class Recorder {
public:
    /// **Collective.** Makes the folders, so that a place that can not be written is known before anything is computed;
    /// takes away what would pass for this run's — frames, series, summary, indices and checkpoints of an older one —
    /// and what a run that died left half-written. Throws SystemError.
    static void claim(const Communicator& comm, const std::filesystem::path& folder,
                      const std::filesystem::path& samples);

    /// **Collective.** The same for a run that goes on: only its summary and half-written files go, and nothing if its
    /// series have lost rows. @param samples needed only while it is being prepared
    static void reclaim(const Communicator& comm, const std::filesystem::path& folder,
                        const nlohmann::ordered_json& course, const std::filesystem::path& samples);

    /// **Collective.** Pre: claim. Throws SystemError. @param state goes on where it was taken (`state`, pre: reclaim): series
    /// are cut to what they were then and frames of later steps go; SystemError if files are not what they were.
    Recorder(Simulation<2>& simulation, const std::filesystem::path& folder,
             const nlohmann::ordered_json* state = nullptr);

    /// **Collective.** All that it remembers, for a checkpoint; the same on all ranks. What is in the files then is on the
    /// disk. Throws SystemError.
    nlohmann::ordered_json state();

    /// **Collective.** When loading starts: remembers what cells and the bed look like, writes the first row of every
    /// series, and scene.toml.
    void begin();

    /// Local. Whether `begin` has been, in this process or before a restart.
    bool begun() const { return !frame_steps_.empty(); }

    /// **Collective.** Whether the series want a row after this loading step, and so the step its residual.
    bool row_due(std::int64_t step) const;

    /// **Collective.** One row in every series, of the interval since the row before.
    void write_row(std::int64_t step, double time);

    /// **Collective.** Rows of gauges and probes that are due after this step, or `all` that have none of it yet.
    void write_sensors(std::int64_t step, double time, bool all);

    /// **Collective.** Throws SystemError on all ranks if it can not be written.
    void write_frame(std::int64_t step, double time);

    /// **Collective.** Ends the series; throws SystemError on all ranks if any row of them could not be written.
    void finish();

    const Overlaps& last_overlaps() const { return overlaps_; }
    double largest_overlap() const { return largest_overlap_; }   ///< of all rows so far
    double largest_residual() const { return largest_residual_; } ///< likewise, 0 before the first step

private:
    struct Series {
        std::vector<SeriesWriter> cells, walls;
        std::unique_ptr<SeriesWriter> front, energy, solver;
    };

    void open_series(const nlohmann::ordered_json* state);
    void resume(const nlohmann::ordered_json& state);
    void measure_again();
    /// Calls f(name of the file, writer) for each; on the root only.
    template <class F>
    void for_each_series(F&& f) {
        const auto& scene = simulation_.scene();
        for (std::size_t k = 0; k < series_.cells.size(); ++k) {
            f("cell-" + scene.output.cells[k].name, series_.cells[k]);
        }
        for (std::size_t k = 0; k < series_.walls.size(); ++k) {
            f("wall-" + scene.walls[k].name, series_.walls[k]);
        }
        if (series_.front) {
            f(std::string("front"), *series_.front);
            f(std::string("energy"), *series_.energy);
            f(std::string("solver"), *series_.solver);
        }
        if (sensors_) {
            sensors_->for_each_series(f);
        }
    }

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
    std::optional<Sensors> sensors_;
    std::vector<CellShape<2>> initial_;
    double bed_ = 0;
    double wall_work_ = 0;       ///< since loading started [J]
    double initial_kinetic_ = 0; ///< when loading started [J]
    Overlaps overlaps_;
    double largest_overlap_ = 0;
    double largest_residual_ = 0;
    std::vector<std::int64_t> frame_steps_; ///< of the frames in the index
};

} // namespace nappe
