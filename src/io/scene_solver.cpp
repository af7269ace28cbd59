#include "io/scene_solver.hpp"

#include "core/method_names.hpp"
#include "io/scene_choice.hpp"

namespace nappe::scene_file {

namespace {

/// What only the plain sweep of nsgs has: `key` is something else than its default, `asked` in words.
void refuse_beside_other_sweeps(const TableReader& table, const char* key, const char* usual, const char* asked,
                                const SolverSettings& solver) {
    const bool of_method = solver.method != SolverSettings::Method::nsgs;
    const bool concerned = table.has(key) || table.has("method") || table.has("adaptive");
    if (!concerned || (!of_method && !solver.adaptive)) {
        return;
    }
    const auto remedy = fmt::format("remove {} = {}, or use nsgs without adaptive", key, asked);
    if (table.has(key) || !table.has(of_method ? "method" : "adaptive")) {
        table.problem(key, fmt::format("must be {} unless method = \"nsgs\" and adaptive is absent", usual), remedy);
    } else if (of_method) {
        table.problem("method", fmt::format("must be \"nsgs\" with {} = {}", key, asked), remedy);
    } else {
        table.problem("adaptive", fmt::format("must be absent with {} = {}", key, asked), remedy);
    }
}

void check_smooth(const TableReader& table, const SolverSettings& solver) {
    if (!is_smooth(solver)) {
        if (table.has("unsafe")) {
            table.problem("unsafe", "must be absent unless method = \"cundall\"",
                          "rigid contacts are solved for, no step makes them unstable: remove it");
        }
        return;
    }
    if (!table.has("method")) {
        return;
    }
    for (const auto* key : {"sweeps", "tolerance", "max_sweeps", "check_every", "at_max", "adaptive", "theta",
                            "coupling", "precision", "warm_start", "geometry_every", "position_correction"}) {
        if (table.has(key)) {
            table.problem(key, "must be absent with method = \"cundall\"",
                          "smooth contacts are not solved for: remove it, or give it to the stages that are rigid");
        }
    }
}

} // namespace

void read_solver_keys(const TableReader& table, SolverSettings& solver, Need step_needed) {
    read_choice<SolverSettings::Method>(table, "method", method_names, solver.method);
    table.read("h", solver.h, positive("s", "give the time step in seconds"), step_needed);
    table.read("theta", solver.theta, between(0.5, 1, "", "0.5 keeps energy, 1 damps most"));
    table.read("sweeps", solver.sweeps, {1, "give the sweeps of a step; with a tolerance, the least"});
    table.read("tolerance", solver.tolerance, positive("", "give the residual at which sweeps may end"));
    table.read("max_sweeps", solver.max_sweeps, {1, "give the most sweeps of a step"});
    table.read("check_every", solver.check_every, {1, "give the sweeps between two looks at the residual"});
    table.read("substeps", solver.substeps, {1, "give the number of parts of a step"});
    table.read("geometry_every", solver.geometry_every, {1, "give the substeps that normals serve for"});
    table.read("adaptive", solver.adaptive, positive("", "give the share of V below which a tile is left alone"));
    using Coupling = SolverSettings::Coupling;
    read_choice<Coupling>(table, "coupling", {{"colour", Coupling::colour}, {"sweep", Coupling::sweep}},
                          solver.coupling);
    using Precision = SolverSettings::Precision;
    read_choice<Precision>(table, "precision", {{"double", Precision::full}, {"single", Precision::single}},
                           solver.precision);
    table.read("warm_start", solver.warm_start, "false starts every step without impulses");
    using AtMax = SolverSettings::AtMax;
    read_choice<AtMax>(table, "at_max", {{"accept", AtMax::accept}, {"stop", AtMax::stop}}, solver.at_max);
    table.read("position_correction", solver.position_correction,
               between(0, 1, "", "give the share of each overlap to take away, 0.8 is usual"));
    table.read("unsafe", solver.unsafe, "true lets a smooth stage have a step that may be unstable");
    check_smooth(table, solver);
    if (is_smooth(solver)) {
        const bool unsafe = solver.unsafe;
        solver = smooth_settings(solver.h, table.has("substeps") ? solver.substeps : 1);
        solver.unsafe = unsafe;
    }
}

void choose(Accuracy accuracy, bool rebounds, bool cohesive, const TableReader& solver_table, SolverSettings& solver) {
    const auto say = [&](const char* key, auto& target, auto value) {
        if (!solver_table.has(key)) {
            target = value;
        }
    };
    switch (accuracy) {
    case Accuracy::fast:
        say("substeps", solver.substeps, 4);
        say("geometry_every", solver.geometry_every, rebounds ? 1 : 4);
        say("adaptive", solver.adaptive, 1e-2);
        break;
    case Accuracy::balanced:
        say("substeps", solver.substeps, 10);
        say("geometry_every", solver.geometry_every, rebounds ? 1 : 10);
        say("adaptive", solver.adaptive, 3e-3);
        if (!cohesive) {
            say("position_correction", solver.position_correction, 0.8);
        }
        break;
    case Accuracy::tight:
        say("method", solver.method, SolverSettings::Method::ansgs);
        say("sweeps", solver.sweeps, 20);
        say("tolerance", solver.tolerance, 1e-4);
        say("substeps", solver.substeps, 10);
        say("max_sweeps", solver.max_sweeps, 10000);
        break;
    }
}

void drop_quiet_tiles(const TableReader& table, SolverSettings& solver) {
    const bool plain = solver.method == SolverSettings::Method::nsgs &&
                       solver.precision == SolverSettings::Precision::full &&
                       solver.coupling == SolverSettings::Coupling::colour;
    if (!plain && !table.has("adaptive")) {
        solver.adaptive.reset();
    }
}

void check_solver(const TableReader& table, const SolverSettings& solver) {
    if (solver.coupling != SolverSettings::Coupling::colour) {
        refuse_beside_other_sweeps(table, "coupling", "\"colour\"", "\"sweep\"", solver);
    }
    if (solver.precision != SolverSettings::Precision::full) {
        refuse_beside_other_sweeps(table, "precision", "\"double\"", "\"single\"", solver);
    }
    const bool either = table.has("adaptive") || table.has("method");
    if (either && solver.adaptive && solver.method != SolverSettings::Method::nsgs) {
        table.problem(table.has("adaptive") ? "adaptive" : "method", "must be absent unless method = \"nsgs\"",
                      "the other methods move all impulses on together; remove adaptive");
    }
    if (table.has("geometry_every") && solver.geometry_every > solver.substeps) {
        table.problem("geometry_every", fmt::format("must be <= substeps = {}", solver.substeps),
                      "normals serve within a step; take more substeps or a smaller number");
    }
    const bool concerned = table.has("tolerance") || table.has("max_sweeps") || table.has("sweeps");
    if (concerned && solver.tolerance && solver.max_sweeps < solver.sweeps) {
        const bool blame_most = table.has("max_sweeps") || !table.has("sweeps");
        table.problem(blame_most ? "max_sweeps" : "sweeps",
                      blame_most ? fmt::format("must be >= sweeps = {} with a tolerance", solver.sweeps)
                                 : fmt::format("must be <= max_sweeps = {} with a tolerance", solver.max_sweeps),
                      "raise max_sweeps or lower sweeps");
    }
}

void refuse_idle_keys(const TableReader& table, bool has_tolerance) {
    for (const auto* key : {"max_sweeps", "check_every", "at_max"}) {
        if (table.has(key) && !has_tolerance) {
            table.problem(key, "must be absent without a tolerance",
                          "add tolerance, or remove this key: it has no effect");
        }
    }
}

} // namespace nappe::scene_file
