#include "commands/check.hpp"

#include "core/error.hpp"
#include "core/initial_grains.hpp"
#include "core/method_names.hpp"
#include "core/polygon.hpp"
#include "core/smooth_step.hpp"
#include "io/progress.hpp"
#include "io/scene_reader.hpp"
#include "solver/disk_batch.hpp"
#include "solver/fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string_view>

namespace nappe {

namespace {

// Measured on settled piles of disks of radii 0.42-0.56 m.
constexpr double solid_fraction = 0.83;
constexpr double contacts_per_grain = 2.1;
constexpr double candidates_per_grain = 2.9;
// Deposits of radii that differ more hold more than that: 4 to 5 % more at 3 times, 22 % at 5, 130 % at 10 (3 m², radii
// up to 0.025 m): small disks also fill holes.
constexpr double similar_radii = 3;

/// [m²]
double mean_grain_area(const RadiusLaw& radii) {
    const double a = radii.min;
    const double b = radii.max;
    return std::numbers::pi * (a * a + a * b + b * b) / 3; // mean of r² for r uniform in [a, b]
}

double sweeps_per_step(const SolverSettings& solver) {
    return static_cast<double>(solver.substeps) * std::ceil(static_cast<double>(solver.sweeps) / solver.substeps);
}

std::string bytes_text(double bytes) {
    constexpr std::array<std::string_view, 5> units = {"B", "kB", "MB", "GB", "TB"};
    std::size_t unit = 0;
    while (bytes >= 1000 && unit + 1 < units.size()) {
        bytes /= 1000;
        ++unit;
    }
    return fmt::format("{:.3g} {}", bytes, units[unit]);
}

/// By what a deposit's number of grains is estimated, and where that falls short.
std::string grains_doubt(const Sample<2>& sample) {
    const bool similar = sample.radii.max <= similar_radii * sample.radii.min;
    return fmt::format(" (solid fraction {}{})", solid_fraction,
                       similar ? "" : "; more, since small ones also fill holes between large ones");
}

std::string solver_text(const SolverSettings& solver) {
    auto text = fmt::format("h {} s, ", solver.h);
    if (!is_smooth(solver)) {
        text += fmt::format("theta {}, ", solver.theta);
    }
    if (solver.substeps > 1) {
        text += fmt::format("{} substeps, ", solver.substeps);
    }
    if (is_smooth(solver)) {
        return text + "smooth contacts (cundall)";
    }
    if (std::min(solver.substeps, solver.geometry_every) > 1) {
        text += fmt::format("normals for {} of them, ", std::min(solver.substeps, solver.geometry_every));
    }
    text += solver.tolerance
                ? fmt::format("{} to {} sweeps, residual {}", solver.sweeps, solver.max_sweeps, *solver.tolerance)
                : fmt::format("{} sweeps", solver.sweeps);
    text += fmt::format(" of {}", method_name(solver.method));
    if (solver.precision == SolverSettings::Precision::single) {
        text += " in single precision";
    }
    if (solver.coupling == SolverSettings::Coupling::sweep) {
        text += ", ranks coupled once a sweep";
    }
    if (solver.adaptive) {
        text += fmt::format(", tiles quiet below {} V", *solver.adaptive);
    }
    if (solver.position_correction > 0) {
        text += fmt::format(", {} of overlaps taken away", solver.position_correction);
    }
    return text;
}

std::string springs_text(const ContactLaw& law) {
    if (!law.springs) {
        return "";
    }
    const auto dashpot = [](const SpringDashpot& spring) {
        return spring.c ? fmt::format("{} N s/m", *spring.c) : std::string("2 sqrt(m_eff k_n)");
    };
    const auto& [normal, tangential] = *law.springs;
    return fmt::format(", springs of {} and {} N/m, dashpots of {} and {}", normal.k, tangential.k, dashpot(normal),
                       dashpot(tangential));
}

std::string stage_text(const Stage& stage) {
    if (stage.until) {
        const bool smooth = is_smooth(stage.solver);
        return fmt::format("until kinetic {} and {} {}, at most {} s ({} steps)", stage.until->kinetic,
                           smooth ? "unbalanced" : "residual", smooth ? stage.until->unbalanced : stage.until->residual,
                           stage.until->at_most, std::llround(stage.until->at_most / stage.solver.h));
    }
    return fmt::format("{} s, {} steps", stage.duration, n_steps(stage));
}

std::string wall_text(const Scene<2>& scene, const Wall<2>& wall) {
    const auto& material = scene.materials[static_cast<std::size_t>(wall.material)].name;
    auto text = fmt::format("{} points of {}", wall.points.size(), material);
    if (!wall.motion) {
        return text + ", fixed";
    }
    const auto& motion = *wall.motion;
    text += fmt::format(", moves at [{}, {}] m/s from ", motion.velocity[0], motion.velocity[1]);
    text += motion.stage >= 0 ? "stage " + scene.stages[static_cast<std::size_t>(motion.stage)].name
                              : fmt::format("{} s", motion.start);
    return motion.stop ? text + fmt::format(" to {} s", *motion.stop) : text;
}

/// How often a gauge or a probe has a row. @param every as the scene has it: 0 as the series
std::string rows_text(const Scene<2>& scene, int every) {
    const int steps = every > 0 ? every : scene.output.series_every;
    std::string text = fmt::format("every {} steps", steps);
    double shown = 0; // seconds of the stage before
    for (const auto& stage : scene.stages) {
        if (const double seconds = steps * stage.solver.h; !stage.until && seconds != shown) {
            text += fmt::format("{}{:.6g} s", shown == 0 ? ", " : " or ", seconds);
            shown = seconds;
        }
    }
    return text;
}

void describe_sensors(const Scene<2>& scene, std::back_insert_iterator<std::string> out) {
    for (const auto& gauge : scene.output.gauges) {
        fmt::format_to(out, "gauge      {}: {} {} of {:.6g} m along {}, from {:.6g} to {:.6g} m; {}\n", gauge.name,
                       gauge.bins, gauge.bins == 1 ? "bin" : "bins", (gauge.to - gauge.from) / gauge.bins,
                       scene.walls[static_cast<std::size_t>(gauge.wall)].name, gauge.from, gauge.to,
                       rows_text(scene, gauge.every));
    }
    for (const auto& probe : scene.output.probes) {
        fmt::format_to(out, "probe      {}: grain {}{}; {}\n", probe.name, probe.grain,
                       probe.grain < 0 ? " (-1 is the last)" : "", rows_text(scene, probe.every));
    }
}

void describe_contents(const Scene<2>& scene, std::back_insert_iterator<std::string> out) {
    fmt::format_to(out, "dimension  2, gravity [{}, {}] m/s²\n", scene.gravity[0], scene.gravity[1]);
    if (scene.sample) {
        const auto& sample = *scene.sample;
        fmt::format_to(out, "sample     {:.6g} m² of {}, radii {} to {} m, {} layers, seed {}\n",
                       std::abs(signed_area(sample.profile)),
                       scene.materials[static_cast<std::size_t>(sample.material)].name, sample.radii.min,
                       sample.radii.max, sample.layer_tops.size() + 1, sample.seed);
    }
    if (!scene.grains.empty()) {
        fmt::format_to(out, "grains     {} given one by one\n", scene.grains.size());
    }
    for (const auto& wall : scene.walls) {
        fmt::format_to(out, "wall       {}: {}\n", wall.name, wall_text(scene, wall));
    }
    for (const auto& law : scene.laws) {
        fmt::format_to(out, "law        {} - {}: frictional, friction {}, restitution {}{}{}\n",
                       scene.materials[static_cast<std::size_t>(law.material_a)].name,
                       scene.materials[static_cast<std::size_t>(law.material_b)].name, law.friction, law.restitution,
                       law.gamma > 0 ? fmt::format(", cohesion of {} N up to a gap of {} m", law.gamma, law.d_w) : "",
                       springs_text(law));
    }
    for (const auto& stage : scene.stages) {
        fmt::format_to(out, "stage      {}: {}; {}\n", stage.name, stage_text(stage), solver_text(stage.solver));
    }
    if (!scene.output.cells.empty()) {
        fmt::format_to(out, "cells      {}\n", scene.output.cells.size());
    }
    describe_sensors(scene, out);
}

/// Those that take bytes and those that only take time.
std::string asked_features(const Features& f) {
    std::string text;
    for (const auto& [asked, name] :
         {std::pair(f.friction, "friction"), std::pair(f.mixed_friction, "mixed friction"),
          std::pair(f.restitution, "restitution"), std::pair(f.cohesion, "cohesion"),
          std::pair(f.turning, "grains that may turn"), std::pair(f.cells, "cells"), std::pair(f.layers, "layers"),
          std::pair(f.driven_walls, "driven walls"), std::pair(f.kept_normals, "kept geometry"),
          std::pair(f.correction, "position correction"), std::pair(f.adaptive, "adaptive sweeps"),
          std::pair(f.single, "single precision"), std::pair(f.smooth, "smooth contacts")}) {
        text += asked ? fmt::format("{}{}", text.empty() ? "" : ", ", name) : "";
    }
    if (f.impulses_kept > 0) {
        text += fmt::format("{}a method that looks back", text.empty() ? "" : ", ");
    }
    return text.empty() ? "nothing" : text;
}

/// What is stored, for the sake of what, and what is not.
template <class Out>
void describe_fields(const Features& features, Out out) {
    constexpr std::array<std::string_view, 3> per = {"grain", "candidate", "packed contact"};
    fmt::format_to(out, "\nasks for   {}\n", asked_features(features));
    fmt::format_to(out, "kernel     {}: {}\n", disk_kernels().name, kernel_variant(features));
    fmt::format_to(out, "carried    {} B per grain, {} B per contact\n", bytes_per_grain(features),
                   bytes_per_contact(features));
    for (const bool carried : {true, false}) {
        if (!carried) {
            fmt::format_to(out, "not carried\n");
        }
        for (const auto& field : fields_of(features)) {
            if (field.carried == carried) {
                fmt::format_to(out, "  {:<24} {:>2} B per {:<15} {}{}\n",
                               fmt::format("{}::{}", field.where, field.name), field.bytes,
                               per[static_cast<std::size_t>(field.per)], field.holds,
                               field.asked_by.empty() ? "" : fmt::format(" (for: {})", field.asked_by));
            }
        }
    }
}

} // namespace

Estimate estimate(const Scene<2>& scene, const CostModel& cost) {
    Estimate e;
    if (const auto known = known_size(scene)) {
        e.grains = static_cast<double>(*known);
    } else {
        e.grains =
            std::abs(signed_area(scene.sample->profile)) * solid_fraction / mean_grain_area(scene.sample->radii) +
            static_cast<double>(scene.grains.size());
    }
    e.contacts = contacts_per_grain * e.grains;
    e.candidates = candidates_per_grain * e.grains;
    const auto features = features_of(scene);
    e.memory = static_cast<double>(bytes_per_grain(features)) * e.grains +
               static_cast<double>(bytes_per_contact(features)) * e.candidates;
    for (const auto& stage : scene.stages) {
        if (!stage.until) {
            const auto steps = static_cast<double>(n_steps(stage));
            e.loading_steps += steps;
            e.relaxations += e.contacts * steps * sweeps_per_step(stage.solver);
        }
    }
    e.seconds = 1e-9 * cost.ns_per_relaxation * e.relaxations;
    // The first state, one every so many steps, and the last if it is not one of those.
    const double between = scene.output.frames_every > 0 ? scene.output.frames_every : std::max(1.0, e.loading_steps);
    e.frames = 1 + std::ceil(e.loading_steps / between);
    e.disk = e.frames * (cost.frame_bytes_per_grain * e.grains + cost.frame_bytes_per_contact * e.contacts);
    return e;
}

std::string describe(const Scene<2>& scene, const CostModel& cost, int ranks) {
    const Estimate e = estimate(scene, cost);
    std::string text;
    auto out = std::back_inserter(text);
    fmt::format_to(out, "{}\n", scene.title.empty() ? "(no title)" : scene.title);
    describe_contents(scene, out);
    describe_fields(features_of(scene), out);
    fmt::format_to(out, "\nestimates, without the stages that settle\n");
    fmt::format_to(out, "grains     {:.0f}{}\n", e.grains, known_size(scene) ? "" : grains_doubt(*scene.sample));
    fmt::format_to(out, "contacts   {:.0f} that touch, {:.0f} candidates\n", e.contacts, e.candidates);
    fmt::format_to(out, "memory     {} in all, {} a rank on {}\n", bytes_text(e.memory), bytes_text(e.memory / ranks),
                   ranks);
    fmt::format_to(out, "work       {:.3g} relaxations in {:.0f} steps\n", e.relaxations, e.loading_steps);
    fmt::format_to(out,
                   "time       {} on 1 rank, {} on {} for the sweeps alone at {} ns per relaxation and rank; half as "
                   "much again in all\n",
                   format_duration(e.seconds), format_duration(e.seconds / ranks), ranks, cost.ns_per_relaxation);
    fmt::format_to(out, "frames     {:.0f}, {}\n", e.frames, bytes_text(e.disk));
    for (const auto& line : smooth_warnings(scene)) {
        fmt::format_to(out, "warning    {}\n", line);
    }
    return text;
}

int check(const std::string& path, const std::vector<std::string>& overrides, const CostModel& cost, int ranks) {
    if (!(std::isfinite(cost.ns_per_relaxation) && cost.ns_per_relaxation > 0)) {
        throw InputError(
            fmt::format("--ns: must be > 0, found {}; give the nanoseconds of one relaxation", cost.ns_per_relaxation));
    }
    if (ranks < 1) {
        throw InputError(
            fmt::format("--ranks: must be >= 1, found {}; give the number of ranks to estimate for", ranks));
    }
    const auto scene = read_scene(path, overrides);
    fmt::print("{}: sound\n{}", path, describe(scene, cost, ranks));
    return static_cast<int>(ExitCode::done);
}

} // namespace nappe
