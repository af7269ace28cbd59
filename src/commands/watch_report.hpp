#pragma once
// What the watch of a run ([watch]) tells the user: lines while it goes on, a line and a part of summary.json at its end.

#include "io/progress.hpp"
#include "solver/simulation.hpp"

#include <nlohmann/json.hpp>

namespace nappe {

/// Local. What has been found since the last call.
void show_watch(Simulation<2>& simulation, Progress& progress);

/// Local. A line if anything was found in the whole run.
void show_watch_total(const Simulation<2>& simulation, Progress& progress);

/// Local. The part `watch` of summary.json.
nlohmann::ordered_json watch_summary(const Simulation<2>& simulation);

} // namespace nappe
