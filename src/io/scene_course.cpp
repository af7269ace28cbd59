// What happens to a scene and how it is computed and shown: stages, tiles, balance, output.
#include "io/scene_choice.hpp"
#include "io/scene_keys.hpp"
#include "io/scene_sections.hpp"
#include "io/scene_solver.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace nappe::scene_file {

namespace {

void read_end(const TableReader& table, Stage& stage, bool loading_before) {
    if (table.has("until") == table.has("duration")) {
        table.problem(table.has("until") ? "duration" : "until", "must be either a criterion or a duration",
                      "give exactly one of until and duration");
        return;
    }
    table.read("duration", stage.duration, positive("s", "give the duration in seconds"));
    const auto until = table.table("until", "stages.until", "write { kinetic = 1e-8, residual = 1e-4 }");
    if (!until) {
        return;
    }
    SettleCriterion criterion;
    until->read("kinetic", criterion.kinetic, positive("", "kinetic energy over weight times mean radius"));
    until->read("residual", criterion.residual, positive("", "give the residual of the step, relative"));
    until->read("unbalanced", criterion.unbalanced, positive("", "give the share of forces that is not balanced"));
    until->read("at_most", criterion.at_most, positive("s", "give the time after which settling is given up"));
    stage.until = criterion;
    if (loading_before) {
        table.problem("until", "must come before every stage with a duration",
                      "preparing stages come first; move this one up");
    }
}

/// What the stage's contacts do not settle by.
void refuse_other_rest(const TableReader& stage, bool smooth) {
    const auto* key = smooth ? "residual" : "unbalanced";
    const auto until = stage.table("until", "stages.until", "write { kinetic = 1e-8, residual = 1e-4 }");
    if (until && until->has(key)) {
        until->problem(
            key, smooth ? "must be absent with method = \"cundall\"" : "must be absent unless method = \"cundall\"",
            smooth ? "smooth contacts have no residual: they settle by unbalanced"
                   : "rigid contacts settle by residual");
    }
}

void read_cells(const TableReader& output, Output<2>& target) {
    const auto cells =
        output.tables("cells", "output.cells", "write [{ name = \"W1\", centre = [25, 11], radius = 5 }]");
    if (cells.size() > 64) {
        output.problem("cells", "must be at most 64", "a grain keeps its cells in 64 bits; split the run");
        return;
    }
    std::vector<std::string> names;
    for (const auto& table : cells) {
        Cell<2> cell;
        cell.name = read_name(table, names, "cell");
        table.read("centre", cell.centre, any_real("m", "give the centre as [x, y]"), Need::required);
        table.read("radius", cell.radius, positive("m", "give the radius in metres"), Need::required);
        names.push_back(cell.name);
        target.cells.push_back(cell);
    }
}

void read_measures(const TableReader& output, MeasureSettings& measures) {
    const auto table = output.table("measures", "output.measures", "write { during_run = true }");
    if (!table) {
        return;
    }
    table->read("during_run", measures.during_run, "true measures at every frame of the run");
    table->read("spacing", measures.spacing, positive("m", "leave it out for four mean radii"));
    table->read("range", measures.range, positive("m", "leave it out for eight mean radii"));
    table->read("energy", measures.energy, "true writes the energy budget");
    // Every grain lies within 0.71 spacings of a node; with a shorter range some would be seen by none.
    if (measures.spacing > 0 && measures.range > 0 && measures.range < measures.spacing) {
        table->problem("range", fmt::format("must be >= output.measures.spacing = {} [m]", measures.spacing),
                       "raise it to two spacings, or choose a finer grid");
    }
}

void read_zone(const TableReader& output, Scene<2>& scene) {
    const auto table = output.table("zone", "output.zone", "write { wall = \"hanging\", tip = [75, 0] }");
    if (!table) {
        return;
    }
    FaultZone<2> zone;
    read_wall(*table, scene, "name the wall that drives the block", zone.wall);
    table->read("tip", zone.tip, any_real("m", "give the fault tip when loading starts as [x, y]"), Need::required);
    table->read("tolerance", zone.tolerance, {0, 0.5, true, "", "give the share of the wall's speed, 0.1 is usual"});
    scene.output.zone = zone;
}

} // namespace

void read_stages(const TableReader& top, Scene<2>& scene) {
    SolverSettings base;
    const auto solver = top.table("solver", "[solver]", "write [solver] with at least h", Need::required);
    if (solver) {
        read_solver_keys(*solver, base, Need::required);
    }
    using Named = std::optional<Accuracy>;
    Named accuracy;
    read_choice<Named>(top, "accuracy",
                       {{"fast", Accuracy::fast}, {"balanced", Accuracy::balanced}, {"tight", Accuracy::tight}},
                       accuracy);
    SolverSettings loading_base = base;
    if (solver && accuracy) {
        const bool rebounds =
            std::any_of(scene.laws.begin(), scene.laws.end(), [](const auto& law) { return law.restitution > 0; });
        const bool cohesive =
            std::any_of(scene.laws.begin(), scene.laws.end(), [](const auto& law) { return law.gamma > 0; });
        choose(*accuracy, rebounds, cohesive, *solver, loading_base);
        drop_quiet_tiles(*solver, loading_base);
    }
    if (solver) {
        check_solver(*solver, loading_base);
    }
    const auto stages = top.tables("stages", "[[stages]]", "write [[stages]]");
    if (stages.empty() && (!top.has("stages") || top.find("stages")->is_array())) {
        top.problem("stages", "must hold at least one stage", "write [[stages]] with a name and a duration or until");
    }
    std::vector<std::string> names;
    bool loading = false;
    bool any_tolerance = base.tolerance.has_value();
    for (const auto& table : stages) {
        Stage stage;
        stage.name = read_name(table, names, "stage");
        names.push_back(stage.name);
        read_end(table, stage, loading);
        loading = loading || !stage.until;
        stage.solver = stage.until ? base : loading_base;
        if (const auto own = table.table("solver", "[solver]", "write solver = { h = 0.01 }")) {
            read_solver_keys(*own, stage.solver, Need::optional);
            if (accuracy && !stage.until && !(solver && solver->has("adaptive"))) {
                drop_quiet_tiles(*own, stage.solver);
            }
            check_solver(*own, stage.solver);
            refuse_idle_keys(*own, stage.solver.tolerance.has_value());
        }
        if (stage.until) {
            refuse_other_rest(table, is_smooth(stage.solver));
        }
        any_tolerance = any_tolerance || stage.solver.tolerance;
        scene.stages.push_back(stage);
    }
    if (solver) {
        refuse_idle_keys(*solver, any_tolerance);
    }
}

void read_tiles(const TableReader& top, Scene<2>& scene) {
    if (const auto table = top.table("tiles", "[tiles]", "write [tiles]")) {
        table->read("side", scene.tiles.side, positive("m", "leave it out for 16 largest radii"));
        table->read("skin", scene.tiles.skin, positive("m", "leave it out for 0.6 largest radii"));
        table->read("lookahead", scene.tiles.lookahead, not_negative("", "give it in steps"));
        table->read("large_above", scene.tiles.large_above,
                    positive("m", "leave it out for 4 times the largest radius of the sample"));
    }
}

void read_balance(const TableReader& top, Scene<2>& scene) {
    if (const auto table = top.table("balance", "[balance]", "write [balance]")) {
        table->read("threshold", scene.balance.threshold,
                    {1, no_limit, false, "", "largest over mean load per rank; 1.01 is usual"});
        table->read("every", scene.balance.every, {1, "give it in steps"});
        using Balance = BalanceSettings;
        read_choice<Balance::By>(*table, "by", {{"work", Balance::By::work}, {"time", Balance::By::time}},
                                 scene.balance.by);
        read_choice<Balance::Moves>(
            *table, "moves", {{"when_it_pays", Balance::Moves::when_it_pays}, {"always", Balance::Moves::always}},
            scene.balance.moves);
    }
}

void read_output(const TableReader& top, Scene<2>& scene) {
    const auto table = top.table("output", "[output]", "write [output]");
    if (!table) {
        return;
    }
    if (const auto frames = table->table("frames", "output.frames", "write { every = 250 }")) {
        frames->read("every", scene.output.frames_every, {0, "give it in steps; 0: only the first and the last state"},
                     Need::required);
    }
    if (const auto series = table->table("series", "output.series", "write { every = 20 }")) {
        series->read("every", scene.output.series_every, {1, "give it in steps"}, Need::required);
    }
    read_cells(*table, scene.output);
    read_gauges(*table, scene);
    read_probes(*table, scene);
    table->read("front_bin", scene.output.front_bin, positive("m", "leave it out for four mean radii"));
    read_measures(*table, scene.output.measures);
    read_zone(*table, scene);
}

} // namespace nappe::scene_file
