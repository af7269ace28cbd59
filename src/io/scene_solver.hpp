#pragma once
// [solver] and the solver tables of stages. Internal to src/io.

#include "core/scene.hpp"
#include "io/scene_table.hpp"

namespace nappe::scene_file {

/// Keys of a solver table over the settings given. Local.
void read_solver_keys(const TableReader& table, SolverSettings& solver, Need step_needed);

/// Knobs that do nothing without another: no knob is silently ignored. Local.
void refuse_idle_keys(const TableReader& table, bool has_tolerance);

} // namespace nappe::scene_file
