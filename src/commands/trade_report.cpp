#include "commands/trade_report.hpp"

#include "io/summary.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace nappe {

namespace {

constexpr auto open_column = "—"; // of what has no figure yet: smooth contacts (docs/accuracy.md)

using Json = nlohmann::ordered_json;

/// Quoted where it holds what separates fields (RFC 4180).
std::string csv_text(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == std::string::npos) {
        return text;
    }
    std::string quoted = "\"";
    for (const char c : text) {
        quoted += c == '"' ? "\"\"" : std::string(1, c);
    }
    return quoted + '"';
}

std::string front_text(bool overlap, bool observables) {
    return overlap && observables ? "both" : overlap ? "overlap" : observables ? "observables" : "-";
}

std::string short_number(double value) {
    return std::isfinite(value) ? fmt::format("{:.3g}", value) : "-";
}

/// Columns as wide as their widest text, the first two to the left, the others to the right.
std::string aligned(const std::vector<std::vector<std::string>>& lines) {
    std::string text;
    // Characters, not bytes: a dash has three.
    const auto width = [](const std::string& cell) {
        return static_cast<std::size_t>(std::count_if(
            cell.begin(), cell.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
    };
    for (const auto& line : lines) {
        std::string row;
        for (std::size_t c = 0; c < line.size(); ++c) {
            std::size_t widest = 0;
            for (const auto& other : lines) {
                widest = std::max(widest, width(other[c]));
            }
            const std::string gap(widest - width(line[c]), ' ');
            row += (c == 0 ? "" : "  ") + (c == 0 ? line[c] + gap : gap + line[c]);
        }
        text += row.substr(0, row.find_last_not_of(' ') + 1) + "\n";
    }
    return text;
}

Json comparison_json(const TradeRow::Compared& one) {
    const auto& c = one.comparison;
    return {{"name", one.observable.name},
            {"unit", one.observable.unit},
            {"seeds", c.n},
            {"mean", c.mean},
            {"reference", c.reference},
            {"difference", c.difference},
            {"standard_error", c.standard_error},
            {"scatter", c.scatter},
            {"resolution", one.observable.resolution},
            {"over_scatter", c.over_scatter},
            {"verdict", verdict_text(c.verdict)}};
}

Json figures_json(const TradeFigures& figures) {
    Json json = Json::object();
    for (const auto& column : trade_columns) {
        json[column.key] = figures.*column.value;
    }
    return json;
}

Json row_json(const TradeRow& row, std::size_t n_seeds) {
    Json json{{"name", row.name}, {"status", trade_status(row, n_seeds)}, {"seeds", row.n_runs}};
    json.update(figures_json(row.figures));
    json["observable_error"] = row.observable_error;
    json["observable_noise"] = row.observable_noise;
    json["front"] = {{"relaxations_overlap", row.fronts.relaxations_overlap},
                     {"relaxations_observables", row.fronts.relaxations_observables},
                     {"seconds_overlap", row.fronts.seconds_overlap},
                     {"seconds_observables", row.fronts.seconds_observables}};
    json["observables"] = Json::array();
    for (const auto& one : row.observables) {
        json["observables"].push_back(comparison_json(one));
    }
    return json;
}

Json result_json(const TradePlan& plan, const TradeResult& result) {
    Json json{{"setting", plan.names[result.setting]}, {"seed", plan.seeds[result.seed]}};
    if (!result.figures) {
        json["failure"] = result.failure;
        return json;
    }
    json.update(figures_json(result.figures->figures));
    for (const auto& observable : result.figures->observables) {
        json["observables"][observable.name] = observable.value;
    }
    return json;
}

} // namespace

std::string trade_status(const TradeRow& row, std::size_t n_seeds) {
    if (row.n_failed > 0) {
        return fmt::format("failed ({} of {}): {}", row.n_failed, n_seeds, row.failure);
    }
    return row.n_runs == n_seeds ? "done" : fmt::format("{} of {} seeds", row.n_runs, n_seeds);
}

std::string trade_csv(const std::vector<TradeRow>& rows, std::size_t n_seeds) {
    std::string text = "setting,seeds";
    for (const auto& column : trade_columns) {
        text += fmt::format(",{}", column.key);
    }
    text += ",observable_error,observable_noise,front_relaxations,front_seconds,smooth_stiffness,status\n";
    for (const auto& row : rows) {
        text += fmt::format("{},{}", row.name, row.n_runs);
        for (const auto& column : trade_columns) {
            text += fmt::format(",{}", row.figures.*column.value);
        }
        text += fmt::format(",{},{},{},{},,{}\n", row.observable_error, row.observable_noise,
                            front_text(row.fronts.relaxations_overlap, row.fronts.relaxations_observables),
                            front_text(row.fronts.seconds_overlap, row.fronts.seconds_observables),
                            csv_text(trade_status(row, n_seeds)));
    }
    return text;
}

std::string observables_csv(const std::vector<TradeRow>& rows) {
    std::string text = "setting,observable,unit,seeds,mean,reference,difference,standard_error,scatter,resolution,over_"
                       "scatter,verdict\n";
    for (const auto& row : rows) {
        for (const auto& [observable, c] : row.observables) {
            text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\n", row.name, observable.name, observable.unit,
                                c.n, c.mean, c.reference, c.difference, c.standard_error, c.scatter,
                                observable.resolution, c.over_scatter, verdict_text(c.verdict));
        }
    }
    return text;
}

std::string trade_text(const std::vector<TradeRow>& rows, std::size_t n_seeds) {
    std::vector<std::vector<std::string>> lines{{"setting", "relaxations", "seconds", "messages", "residual",
                                                 "overlap mean", "largest", "on walls", "least", "energy", "differ",
                                                 "observables", "noise", "front relax.", "front seconds", "smooth"}};
    std::string failures;
    for (const auto& row : rows) {
        const auto& f = row.figures;
        const auto differing = std::count_if(row.observables.begin(), row.observables.end(), [](const auto& one) {
            return one.comparison.verdict == Verdict::differs;
        });
        const auto known = std::count_if(row.observables.begin(), row.observables.end(), [](const auto& one) {
            return one.comparison.verdict == Verdict::differs || one.comparison.verdict == Verdict::within;
        });
        lines.push_back({row.name, short_number(f.relaxations), short_number(f.seconds_steps), short_number(f.messages),
                         short_number(f.residual), short_number(f.overlap_mean), short_number(f.overlap_max_of_rows),
                         short_number(f.weight_on_walls), short_number(f.weight_on_walls_least),
                         short_number(f.energy_closure), known > 0 ? fmt::format("{}/{}", differing, known) : "-",
                         short_number(row.observable_error), short_number(row.observable_noise),
                         front_text(row.fronts.relaxations_overlap, row.fronts.relaxations_observables),
                         front_text(row.fronts.seconds_overlap, row.fronts.seconds_observables), open_column});
        if (const auto status = trade_status(row, n_seeds); status != "done") {
            failures += fmt::format("{}: {}\n", row.name, status);
        }
    }
    std::string text = aligned(lines);
    text += "seconds: of the steps, without measuring and writing. overlap: over radius, mean at the end, largest of "
            "all rows. on walls: share of the\nweight, late, and the least of all rows. differ: observables that "
            "differ from the reference by more "
            "than chance. observables: root mean square of the differences\nover the scatter of the reference between "
            "seeds; noise: what chance leaves of it. front: on the Pareto front of cost against mean overlap\nand "
            "against observables. docs/accuracy.md defines all.\n";
    if (n_seeds < 2) {
        text += "One seed: no scatter is known, and no observable can be judged. --seeds 8 runs the seeds 1 to 8.\n";
    }
    if (const auto tight = as_tight_as_reference(rows); !tight.empty()) {
        text +=
            fmt::format("The reference is no tighter than {} (largest residual and mean overlap): give it more work, "
                        "or its own error counts as theirs.\n",
                        fmt::join(tight, ", "));
    }
    return text + failures;
}

Json trade_json(const TradePlan& plan, const TradeMatrix& matrix, const std::vector<TradeResult>& results,
                const std::vector<TradeRow>& rows) {
    Json json{{"version", program_version()},
              {"title", plan.runs.front().scene.title},
              {"scene", plan.runs.front().scene.text},
              {"matrix", matrix.text},
              {"window", matrix.window},
              {"seeds", plan.seeds}};
    json["as_tight_as_reference"] = as_tight_as_reference(rows);
    json["settings"] = Json::array();
    for (const auto& row : rows) {
        json["settings"].push_back(row_json(row, plan.seeds.size()));
    }
    json["runs"] = Json::array();
    for (const auto& result : results) {
        json["runs"].push_back(result_json(plan, result));
    }
    return json;
}

} // namespace nappe
