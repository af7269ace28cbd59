// What is watched while a scene runs, and what becomes of a step in which something is found.
#include "io/scene_choice.hpp"
#include "io/scene_sections.hpp"

namespace nappe::scene_file {

namespace {

using Watch = WatchSettings<2>;

void read_then(const TableReader& table, Watch::Then& then) {
    using Then = Watch::Then;
    read_choice<Then>(table, "do", {{"warn", Then::warn}, {"substep", Then::substep}, {"stop", Then::stop}}, then);
}

void read_bounds(const TableReader& watch, Watch& target) {
    const auto table =
        watch.table("bounds", "watch.bounds", "write { min = [-10, -10], max = [260, 100], do = \"stop\" }");
    if (!table) {
        return;
    }
    Watch::Bounds bounds;
    const bool min =
        table->read("min", bounds.min, any_real("m", "give the lower left corner as [x, y]"), Need::required);
    const bool max =
        table->read("max", bounds.max, any_real("m", "give the upper right corner as [x, y]"), Need::required);
    if (min && max && !(bounds.min[0] < bounds.max[0] && bounds.min[1] < bounds.max[1])) {
        table->problem(
            "max", fmt::format("must be > watch.bounds.min = [{}, {}] [m] in x and in y", bounds.min[0], bounds.min[1]),
            "give the lower left and the upper right corner");
    }
    read_then(*table, bounds.then);
    target.bounds = bounds;
}

} // namespace

void read_watch(const TableReader& top, Scene<2>& scene) {
    const auto watch = top.table("watch", "[watch]", "write [watch]");
    if (!watch) {
        return;
    }
    auto& target = scene.watch;
    if (const auto table = watch->table("overlap", "watch.overlap", "write { limit = 0.2, do = \"stop\" }")) {
        table->read("limit", target.overlap.limit, positive("", "give the overlap over the smaller radius"));
        read_then(*table, target.overlap.then);
    }
    if (const auto table = watch->table("energy", "watch.energy", "write { limit = 0.1, do = \"stop\" }")) {
        table->read("limit", target.energy.limit, positive("", "give the share of the energies of docs/scene.md"));
        read_then(*table, target.energy.then);
    }
    if (const auto table = watch->table("residual", "watch.residual", "write { steps = 10, do = \"stop\" }")) {
        table->read("steps", target.residual.steps, {1, "give the steps in a row above solver.tolerance"});
        read_then(*table, target.residual.then);
    }
    read_bounds(*watch, target);
    if (const auto table = watch->table("failure", "watch.failure", "write { do = \"substep\" }")) {
        using Then = Watch::Then;
        read_choice<Then>(*table, "do", {{"stop", Then::stop}, {"substep", Then::substep}}, target.failure);
    }
    watch->read("max_substeps", target.max_substeps,
                {2, "give the most substeps of a step that is done again", 1 << 20});
}

} // namespace nappe::scene_file
