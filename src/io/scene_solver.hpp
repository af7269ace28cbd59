#pragma once
// [solver] and the solver tables of stages. Internal to src/io.

#include "core/scene.hpp"
#include "io/scene_table.hpp"

namespace nappe::scene_file {

/// Keys of a solver table over the settings given. Local.
void read_solver_keys(const TableReader& table, SolverSettings& solver, Need step_needed);

/// What a named accuracy (top-level key `accuracy`) chooses where the file's own [solver] says nothing. docs/accuracy.md has
/// what each costs and is worth. @param rebounds whether some law has restitution: then normals are never kept. @param cohesive
/// whether some law attracts: then positions are not corrected. Local.
enum class Accuracy { fast, balanced, tight };
void choose(Accuracy accuracy, bool rebounds, bool cohesive, const TableReader& solver_table, SolverSettings& solver);

/// Takes back the quiet tiles that an accuracy chose, where `table` asks for sweeps that have none and does not name them
/// itself. Local.
void drop_quiet_tiles(const TableReader& table, SolverSettings& solver);

/// Rules between keys, told at a table that takes part in the matter. Local.
void check_solver(const TableReader& table, const SolverSettings& solver);

/// Knobs that do nothing without another: no knob is silently ignored. Local.
void refuse_idle_keys(const TableReader& table, bool has_tolerance);

} // namespace nappe::scene_file
