#include "commands/trade_figures.hpp"

#include "core/error.hpp"
#include "core/no_value.hpp"
#include "io/series_reader.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>

namespace nappe {

namespace {

/// Rows after the start: at step 0 nothing has been computed with the setting yet.
std::vector<double> after_start(const SeriesTable& table, const std::string& column) {
    std::vector<double> values;
    for (std::size_t r = 0; r < table.n_rows(); ++r) {
        if (table["step"][r] > 0) {
            values.push_back(table[column][r]);
        }
    }
    return values;
}

/// Of those that are numbers; NaN if none is.
double mean_of(const std::vector<double>& values) {
    double sum = 0;
    int n = 0;
    for (const double v : values) {
        if (std::isfinite(v)) {
            sum += v;
            ++n;
        }
    }
    return n > 0 ? sum / n : no_value;
}

std::vector<double> numbers(std::vector<double> values) {
    std::erase_if(values, [](double v) { return !std::isfinite(v); });
    return values;
}

double largest_of(const std::vector<double>& values) {
    const auto known = numbers(values);
    return known.empty() ? no_value : *std::max_element(known.begin(), known.end());
}

double least_of(const std::vector<double>& values) {
    const auto known = numbers(values);
    return known.empty() ? no_value : *std::min_element(known.begin(), known.end());
}

double median_of(const std::vector<double>& values) {
    auto known = numbers(values);
    if (known.empty()) {
        return no_value;
    }
    std::sort(known.begin(), known.end());
    const auto half = known.size() / 2;
    return known.size() % 2 == 1 ? known[half] : 0.5 * (known[half - 1] + known[half]);
}

/// The values of the window's rows: those later than its start, and the last row in any case.
std::vector<double> in_window(const SeriesTable& table, const std::string& column, double window) {
    const auto& time = table["time"];
    const auto& value = table[column];
    std::vector<double> values;
    for (std::size_t r = 0; r < table.n_rows(); ++r) {
        if (r + 1 == table.n_rows() || (time[r] > 0 && time[r] > (1 - window) * time.back())) {
            values.push_back(value[r]);
        }
    }
    return values;
}

nlohmann::json read_summary(const std::filesystem::path& path) {
    std::ifstream file(path);
    auto json = nlohmann::json::parse(file, nullptr, false);
    if (!json.is_object()) {
        throw InputError(fmt::format("{}: must be the summary of a run, found something else; delete its run to have "
                                     "it made again",
                                     path.string()));
    }
    return json;
}

double number(const nlohmann::json& json, const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_number() ? found->get<double>() : no_value;
}

void read_costs(const nlohmann::json& summary, TradeFigures& f) {
    f.relaxations = number(summary, "relaxations");
    f.sweeps = number(summary, "sweeps");
    f.steps = number(summary, "steps");
    f.unconverged_steps = number(summary, "unconverged_steps");
    f.ns_per_relaxation = number(summary, "ns_per_relaxation");
    f.messages = number(summary, "messages");
    f.message_bytes = number(summary, "message_bytes");
    f.seconds_loading = number(summary, "seconds_loading");
    const auto& seconds = summary.value("seconds", nlohmann::json::object());
    f.seconds_steps = f.seconds_loading - number(seconds, "measure") - number(seconds, "output");
    f.seconds_sweeping = number(seconds, "sweep") + number(seconds, "exchange");
}

/// Share of the grains' weight that walls carry: forces of the grains on all walls, along gravity. Whatever is missing
/// from 1 in a row is the mean acceleration of the grains' centre of mass over the row's interval, over |g|.
void read_weight(const std::filesystem::path& folder, const Scene<2>& scene, double mass, double window,
                 TradeFigures& f) {
    const double g = scene.gravity.norm();
    if (!(g > 0) || scene.walls.empty()) {
        f.weight_on_walls = f.weight_on_walls_least = no_value;
        return;
    }
    const Vec<2> down = scene.gravity / g;
    std::vector<double> all, late;
    const auto add = [&](std::vector<double>& sums, const std::vector<double>& x, const std::vector<double>& y) {
        sums.resize(x.size(), 0.0);
        for (std::size_t r = 0; r < x.size(); ++r) {
            sums[r] += (down[0] * x[r] + down[1] * y[r]) / (mass * g);
        }
    };
    for (const auto& wall : scene.walls) {
        const auto table = read_series(folder / "series" / ("wall-" + wall.name + ".csv"));
        add(all, after_start(table, "fx"), after_start(table, "fy"));
        add(late, in_window(table, "fx", window), in_window(table, "fy", window));
    }
    f.weight_on_walls = mean_of(late);
    f.weight_on_walls_least = least_of(all);
}

void read_energy(const std::filesystem::path& folder, TradeFigures& f) {
    const auto table = read_series(folder / "series" / "energy.csv");
    double work = 0, error = 0;
    for (const auto* column : {"wall_work", "gravity", "friction", "impact", "cohesion", "theta_term"}) {
        for (const double v : table[column]) {
            work = std::max(work, std::abs(v));
        }
    }
    for (const double v : table["error"]) {
        error = std::max(error, std::abs(v));
    }
    f.energy_closure = work > 0 ? error / work : no_value;
}

void read_solver(const std::filesystem::path& folder, const nlohmann::json& summary, TradeFigures& f) {
    const auto table = read_series(folder / "series" / "solver.csv");
    f.residual = number(summary, "residual");
    f.residual_largest = largest_of(after_start(table, "residual"));
    f.overlap_mean_start = table.n_rows() > 0 ? table["overlap_mean"].front() : no_value;
    f.overlap_max_start = table.n_rows() > 0 ? table["overlap_max"].front() : no_value;
    f.overlap_mean = number(summary, "overlap_mean");
    f.overlap_max = number(summary, "overlap_max");
    f.overlap_mean_of_rows = mean_of(after_start(table, "overlap_mean"));
    f.overlap_max_of_rows = largest_of(after_start(table, "overlap_max"));
}

/// Width of the bins that front and crest are rounded to [m].
double bin_of(const Scene<2>& scene) {
    const double mean_radius = scene.sample ? 0.5 * (scene.sample->radii.min + scene.sample->radii.max) : 0.0;
    return scene.output.bin_for(mean_radius);
}

std::vector<Observable> read_observables(const std::filesystem::path& folder, const Scene<2>& scene, double window) {
    std::vector<Observable> found;
    const auto add = [&](const SeriesTable& table, const std::string& column, const std::string& prefix,
                         const std::string& unit, double resolution = 0) {
        found.push_back({prefix + column, unit, mean_of(in_window(table, column, window)), resolution});
    };
    const double rounding = bin_of(scene) / std::sqrt(12.0); // standard deviation of what is spread evenly over a bin
    const auto surface = read_series(folder / "measures" / "surface.csv");
    add(surface, "front", "", "m", rounding);
    add(surface, "crest", "", "m", rounding);
    add(surface, "slope", "", "rad");
    for (const auto& cell : scene.output.cells) {
        const auto table = read_series(folder / "series" / ("cell-" + cell.name + ".csv"));
        add(table, "p", cell.name + ".", "Pa");
        add(table, "q", cell.name + ".", "Pa");
    }
    if (scene.output.zone) {
        const auto zone = read_series(folder / "measures" / "zone.csv");
        add(zone, "left_angle", "zone.", "rad");
        add(zone, "right_angle", "zone.", "rad");
        add(zone, "opening", "zone.", "rad");
    }
    return found;
}

} // namespace

TradeFigures over_seeds(const std::vector<TradeFigures>& runs) {
    TradeFigures all;
    for (const auto& column : trade_columns) {
        std::vector<double> values;
        values.reserve(runs.size());
        for (const auto& run : runs) {
            values.push_back(run.*column.value);
        }
        all.*column.value = column.over == OverSeeds::mean      ? mean_of(values)
                            : column.over == OverSeeds::median  ? median_of(values)
                            : column.over == OverSeeds::largest ? largest_of(values)
                                                                : least_of(values);
    }
    return all;
}

RunFigures read_run(const std::filesystem::path& folder, const Scene<2>& scene, double window) {
    const auto summary = read_summary(folder / "summary.json");
    RunFigures run;
    read_costs(summary, run.figures);
    read_solver(folder, summary, run.figures);
    read_weight(folder, scene, number(summary, "mass"), window, run.figures);
    read_energy(folder, run.figures);
    run.observables = read_observables(folder, scene, window);
    return run;
}

} // namespace nappe
