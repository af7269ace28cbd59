#pragma once
// Series with intervals of their own: gauges along walls, and probes of single grains (output.gauges, output.probes).

#include "io/series.hpp"
#include "solver/simulation.hpp"

#include <nlohmann/json.hpp>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace nappe {

class Sensors {
public:
    /// Local. On the root, opens the series. @param state goes on where it was taken; nullptr: from the start
    /// @param bytes of series then, by name
    Sensors(Simulation<2>& simulation, const std::filesystem::path& folder, const nlohmann::ordered_json* state,
            const nlohmann::ordered_json* bytes);

    /// **Collective.** When loading starts, with the impulses of the sample in the gauges, as if of one step of h: the first
    /// rows. Throws InputError if a probe's grain is not there.
    void begin(double h);

    /// **Collective.** Rows that are due after this loading step, of the time since the row before. @param all: of all
    /// that have none of this step yet @returns whether there were any
    bool write(std::int64_t step, double time, bool all);

    /// All that is remembered between rows; the same on all ranks. Local.
    nlohmann::ordered_json state() const;

    /// Calls f(name of the file, writer) for each; on the root only.
    template <class F>
    void for_each_series(F&& f) {
        const auto& output = simulation_.scene().output;
        for (std::size_t k = 0; k < gauge_series_.size(); ++k) {
            f("gauge-" + output.gauges[k].name, gauge_series_[k]);
        }
        for (std::size_t k = 0; k < probe_series_.size(); ++k) {
            f("probe-" + output.probes[k].name, probe_series_[k]);
        }
    }

private:
    /// Of a series.
    struct Last {
        std::int64_t step = -1;
        double time = 0; ///< [s]
    };
    struct Seen { ///< a probe's grain; on its owner
        std::int64_t found = 0;
        std::array<double, 2> x{}, v{}; ///< [m], [m/s]
        double spin = 0;                ///< [rad/s]
    };

    bool due(std::int64_t step, int every, const Last& last, bool all) const;
    void write_gauge(std::size_t gauge, std::int64_t step, double time, double interval);
    void write_probe(std::size_t probe, std::int64_t step, double time);
    Seen look(std::size_t probe) const;

    Simulation<2>& simulation_;
    std::vector<SeriesWriter> gauge_series_, probe_series_; ///< on the root only
    std::vector<Last> last_of_gauge_, last_of_probe_;
    std::vector<Vec<2>> start_; ///< of a probe's grain, when loading starts [m]
};

/// **Collective.** Throws InputError if a grain that the scene probes is not there. @param to_come more grains than there are
/// now
void check_probes(const Simulation<2>& simulation, std::int64_t to_come = 0);

} // namespace nappe
