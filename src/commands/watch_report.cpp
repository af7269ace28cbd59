#include "commands/watch_report.hpp"

#include <fmt/format.h>

namespace nappe {

void show_watch(Simulation<2>& simulation, Progress& progress) {
    for (const auto& line : simulation.watcher().take_lines()) {
        progress.warning(line);
    }
}

void show_watch_total(const Simulation<2>& simulation, Progress& progress) {
    const auto& memory = simulation.watcher().memory();
    std::string text;
    for (std::size_t k = 0; k < n_watched; ++k) {
        if (memory.steps[k] > 0) {
            text += fmt::format("{}{} in {} steps", text.empty() ? "" : ", ", watched_names[k], memory.steps[k]);
        }
    }
    if (memory.divided_steps > 0) {
        text += fmt::format("{}{} steps done again with up to {} substeps", text.empty() ? "" : ", ",
                            memory.divided_steps, memory.most_substeps);
    }
    if (!text.empty()) {
        progress.warning(fmt::format("found by the watch in {} steps: {}", simulation.counters().steps, text));
    }
}

nlohmann::ordered_json watch_summary(const Simulation<2>& simulation) {
    const auto& memory = simulation.watcher().memory();
    nlohmann::ordered_json json;
    for (std::size_t k = 0; k < n_watched; ++k) {
        json[watched_names[k]] = memory.steps[k];
    }
    json["divided_steps"] = memory.divided_steps;
    json["most_substeps"] = memory.most_substeps;
    json["largest_growth"] = memory.largest_growth;
    return json;
}

} // namespace nappe
