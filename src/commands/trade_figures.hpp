#pragma once
// What `nappe trade` reads off the folder of a finished run: its costs, its errors, its observables.

#include "core/scene.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace nappe {

/// Costs and errors of a run, or of a setting over its seeds (docs/accuracy.md). NaN: there is nothing to measure.
struct TradeFigures {
    double relaxations = 0, sweeps = 0, steps = 0, unconverged_steps = 0;
    double seconds_loading = 0;  ///< wall-clock
    double seconds_steps = 0;    ///< of them, without measuring and writing
    double seconds_sweeping = 0; ///< of them, sweeps with their messages
    double ns_per_relaxation = 0, messages = 0, message_bytes = 0;
    double residual = 0, residual_largest = 0;             ///< at the end; of all rows
    double overlap_mean_start = 0, overlap_max_start = 0;  ///< of the sample: no setting pushes out what is there
    double overlap_mean = 0, overlap_mean_of_rows = 0;     ///< at the end; mean of all rows
    double overlap_max = 0, overlap_max_of_rows = 0;       ///< at the end; largest of all rows
    double weight_on_walls = 0, weight_on_walls_least = 0; ///< mean of the window; least of all rows
    double energy_closure = 0;                             ///< what the budget does not explain, over the work done
};

/// How the values of several seeds become one.
enum class OverSeeds { mean, median, largest, least };

struct TradeColumn {
    const char* key;
    double TradeFigures::*value;
    OverSeeds over;
};

/// All figures, in the order of trade.csv. Times scatter upwards, where something disturbs: the median.
inline constexpr std::array trade_columns = {
    TradeColumn{"relaxations", &TradeFigures::relaxations, OverSeeds::mean},
    TradeColumn{"sweeps", &TradeFigures::sweeps, OverSeeds::mean},
    TradeColumn{"steps", &TradeFigures::steps, OverSeeds::mean},
    TradeColumn{"unconverged_steps", &TradeFigures::unconverged_steps, OverSeeds::mean},
    TradeColumn{"seconds_loading", &TradeFigures::seconds_loading, OverSeeds::median},
    TradeColumn{"seconds_steps", &TradeFigures::seconds_steps, OverSeeds::median},
    TradeColumn{"seconds_sweeping", &TradeFigures::seconds_sweeping, OverSeeds::median},
    TradeColumn{"ns_per_relaxation", &TradeFigures::ns_per_relaxation, OverSeeds::median},
    TradeColumn{"messages", &TradeFigures::messages, OverSeeds::mean},
    TradeColumn{"message_bytes", &TradeFigures::message_bytes, OverSeeds::mean},
    TradeColumn{"residual", &TradeFigures::residual, OverSeeds::mean},
    TradeColumn{"residual_largest", &TradeFigures::residual_largest, OverSeeds::largest},
    TradeColumn{"overlap_mean_start", &TradeFigures::overlap_mean_start, OverSeeds::mean},
    TradeColumn{"overlap_max_start", &TradeFigures::overlap_max_start, OverSeeds::largest},
    TradeColumn{"overlap_mean", &TradeFigures::overlap_mean, OverSeeds::mean},
    TradeColumn{"overlap_mean_of_rows", &TradeFigures::overlap_mean_of_rows, OverSeeds::mean},
    TradeColumn{"overlap_max", &TradeFigures::overlap_max, OverSeeds::mean},
    TradeColumn{"overlap_max_of_rows", &TradeFigures::overlap_max_of_rows, OverSeeds::largest},
    TradeColumn{"weight_on_walls", &TradeFigures::weight_on_walls, OverSeeds::mean},
    TradeColumn{"weight_on_walls_least", &TradeFigures::weight_on_walls_least, OverSeeds::least},
    TradeColumn{"energy_closure", &TradeFigures::energy_closure, OverSeeds::largest},
};

/// Seed by seed to one; NaN counts for nothing, and if all are NaN so is the result. Local.
TradeFigures over_seeds(const std::vector<TradeFigures>& runs);

struct Observable {
    std::string name, unit;
    double value = 0;      ///< mean over the window of the rows that have a value; NaN if none has
    double resolution = 0; ///< standard deviation that rounding to bins alone leaves; 0 if it is not rounded
};

struct RunFigures {
    TradeFigures figures;
    std::vector<Observable> observables; ///< the same names in the same order for every run of a scene
};

/// Reads a finished run of `scene`, with measures and energy budget. Local. Throws InputError if a file is missing or
/// damaged. @param window share of loading, at its end, that observables are averaged over
RunFigures read_run(const std::filesystem::path& folder, const Scene<2>& scene, double window);

} // namespace nappe
