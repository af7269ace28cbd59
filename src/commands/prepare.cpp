#include "commands/prepare.hpp"

#include "commands/drop.hpp"
#include "commands/sensors.hpp"
#include "commands/watched_step.hpp"
#include "core/error.hpp"
#include "core/initial_grains.hpp"
#include "core/large_grains.hpp"
#include "io/stored_manifest.hpp"
#include "solver/observables.hpp"
#include "solver/smooth_energy.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>

namespace nappe {

namespace {

constexpr int settle_check_every = 10; ///< steps between two looks at the criterion

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::string line_of(const std::vector<Vec<2>>& points) {
    std::string text;
    for (const auto& p : points) {
        text += fmt::format(" [{}, {}]", p[0], p[1]);
    }
    return text;
}

struct SettleState {
    double kinetic = 0; ///< over weight times mean radius
    double rest = 0;    ///< the residual, or of smooth contacts the unbalanced force
};

const char* name_of_rest(const Simulation<2>& simulation) {
    return is_smooth(simulation.settings()) ? "unbalanced force" : "residual";
}

SettleState settle_state(const Simulation<2>& simulation) {
    const double scale = simulation.total_mass() * simulation.scene().gravity.norm() * simulation.mean_radius();
    const double kinetic = energies(simulation).kinetic;
    return {scale > 0 ? kinetic / scale : kinetic, is_smooth(simulation.settings()) ? unbalanced_force(simulation)
                                                   : simulation.last_residual() ? simulation.last_residual()->largest
                                                                                : 0.0};
}

double wanted_rest(const Simulation<2>& simulation, const SettleCriterion& wanted) {
    return is_smooth(simulation.settings()) ? wanted.unbalanced : wanted.residual;
}

bool is_settled(const Simulation<2>& simulation, const SettleState& now, const SettleCriterion& wanted) {
    return now.kinetic <= wanted.kinetic && now.rest <= wanted_rest(simulation, wanted);
}

NumericalFailure unsettled(const Simulation<2>& simulation, const std::string& stage, const SettleState& now,
                           const SettleCriterion& wanted) {
    return NumericalFailure(fmt::format(
        "stage '{}' did not settle within {} s: kinetic energy over weight x mean radius is {:.3g} (wanted {:.3g}), "
        "{} {:.3g} (wanted {:.3g}); allow more time (until.at_most), {}, or ask for less",
        stage, wanted.at_most, now.kinetic, wanted.kinetic, name_of_rest(simulation), now.rest,
        wanted_rest(simulation, wanted), is_smooth(simulation.settings()) ? "more damping" : "more sweeps"));
}

/// Steps of one settling stage, from its start or on from where the simulation is. Throws NumericalFailure if it takes too
/// long. @param keep writes a checkpoint
void settle(Simulation<2>& simulation, int stage, bool goes_on, Progress& progress, Checkpointer& checkpointer,
            const std::function<bool()>& keep) {
    const auto& name = simulation.scene().stages[static_cast<std::size_t>(stage)].name;
    const auto& wanted = *simulation.scene().stages[static_cast<std::size_t>(stage)].until;
    if (!goes_on) {
        simulation.start_stage(stage);
    }
    progress.begin_stage(name, 0, simulation.stage_steps());
    for (;;) {
        const bool look = (simulation.stage_steps() + 1) % settle_check_every == 0;
        const auto agreed = watched_step(simulation, look, checkpointer, progress, keep);
        progress.update(simulation.stage_steps(), simulation.time());
        if (look) { // before any checkpoint: a restart does not look again
            const auto now = settle_state(simulation);
            if (is_settled(simulation, now, wanted)) {
                break;
            }
            if (simulation.time() >= wanted.at_most) {
                if (!checkpointer.never() && keep()) {
                    progress.warning(fmt::format("what has settled so far is in a checkpoint: nappe restart with more "
                                                 "time (--set stages.{}.until.at_most=…) goes on from there",
                                                 name));
                }
                throw unsettled(simulation, name, now, wanted);
            }
        }
        const bool stops = Checkpointer::stops(agreed);
        if (stops || checkpointer.due(agreed, simulation.stage_steps())) {
            const bool kept = !checkpointer.never() && keep();
            if (stops) {
                throw StoppedEarly{kept};
            }
        }
    }
    progress.end_stage();
    const auto end = settle_state(simulation);
    progress.info(fmt::format("settled after {} steps: kinetic {:.3g}, {} {:.3g}", simulation.stage_steps(),
                              end.kinetic, name_of_rest(simulation), end.rest));
}

/// What a smooth stage goes by, beside frictions.
std::string springs_text(const Scene<2>& scene, double unbalanced) {
    std::string text = fmt::format("smooth contacts of revision 1, unbalanced {}\n", unbalanced);
    for (const auto& l : scene.laws) {
        const auto dashpot = [](const SpringDashpot& of) { return of.c ? fmt::format("{}", *of.c) : "critical"; };
        if (l.springs) {
            const auto& [normal, tangential] = *l.springs;
            text += fmt::format("springs {} {} normal {} {} tangential {} {}\n", l.material_a, l.material_b, normal.k,
                                dashpot(normal), tangential.k, dashpot(tangential));
        }
    }
    for (const auto& m : scene.materials) {
        text += fmt::format("damping {} {} {}\n", m.name, m.damping, m.spin_damping);
    }
    return text;
}

} // namespace

SampleOrigin sample_origin(const Scene<2>& scene, int n_ranks) {
    // Of tiles, in the scene's own coordinates: a sample is the same wherever its scene lies.
    std::string text = fmt::format("gravity [{}, {}] origin [0, 0]\n", scene.gravity[0], scene.gravity[1]);
    for (const auto& m : scene.materials) {
        text += fmt::format("material {} {}\n", m.name, m.density);
    }
    for (const auto& l : scene.laws) {
        text += fmt::format("law {} {} friction {} restitution {}\n", l.material_a, l.material_b, l.friction,
                            l.restitution);
    }
    if (scene.sample) {
        const auto& s = *scene.sample;
        text += fmt::format("sample {} radii {} {} {} seed {} layers {} profile{}\n", s.material,
                            static_cast<int>(s.radii.kind), s.radii.min, s.radii.max, s.seed,
                            fmt::join(s.layer_tops, " "), line_of(s.profile));
        if (s.arrangement != Sample<2>::Arrangement::deposit) {
            text += s.arrangement == Sample<2>::Arrangement::square ? "square lattice\n" : "staggered lattice\n";
        }
    }
    for (const auto& g : scene.grains) {
        if (g.drop) { // not of the sample
            continue;
        }
        text += fmt::format("grain {} {} [{}, {}] [{}, {}] {} {}\n", g.material, g.radius, g.position[0], g.position[1],
                            g.velocity[0], g.velocity[1], g.spin[0], g.layer);
    }
    for (const auto& w : scene.walls) {
        text += fmt::format("wall {}{}", w.material, line_of(w.points));
        text += "\n";
    }
    for (const auto& stage : scene.stages) {
        if (stage.until) {
            const auto& s = stage.solver;
            text += fmt::format("settle {} {} h {} substeps {} theta {} sweeps {} tolerance {} {} {} method {}\n",
                                stage.until->kinetic, stage.until->residual, s.h, s.substeps, s.theta, s.sweeps,
                                s.tolerance.value_or(0.0), s.max_sweeps, s.check_every, static_cast<int>(s.method));
            if (is_smooth(s)) {
                text += springs_text(scene, stage.until->unbalanced);
            }
            if (s.adaptive || s.geometry_every > 1 || s.position_correction > 0) {
                text += fmt::format("adaptive {} geometry every {} correction {}\n", s.adaptive.value_or(0.0),
                                    s.geometry_every, s.position_correction);
            }
            // Rules of the code that a sample depends on belong to its key; those of plain sweeps are physics_revision.
            if (s.method != SolverSettings::Method::nsgs || s.substeps > 1 || s.adaptive || s.position_correction > 0) {
                text += "methods, substeps and corrections of revision 2\n";
            }
            if (s.coupling == SolverSettings::Coupling::sweep && n_ranks > 1) { // follows who owns which tiles
                text += fmt::format("coupled by sweep on {} ranks, balance {} every {}\n", n_ranks,
                                    scene.balance.threshold, scene.balance.every);
            }
            if (s.precision == SolverSettings::Precision::single) {
                text += "swept in single precision\n";
            }
            if (!s.warm_start) {
                text += "cold\n";
            }
            if (s.tolerance) { // so is the lag
                text += fmt::format("a check acts {} sweeps later\n", check_lag(s));
            }
        }
    }
    text += fmt::format("tiles {} {} {}\n", scene.tiles.side, scene.tiles.skin, scene.tiles.lookahead);
    if (has_large_grains(scene, false)) {
        text += fmt::format("large above {}\n", large_above(scene));
    }
    return {physics_revision, text};
}

nlohmann::ordered_json to_json(const Preparation& p) {
    return {{"reused", p.reused},
            {"settle_steps", p.settle_steps},
            {"deposit_seconds", p.deposit_seconds},
            {"settle_seconds", p.settle_seconds}};
}

Preparation preparation_from(const nlohmann::ordered_json& json) {
    Preparation p;
    json.at("reused").get_to(p.reused);
    json.at("settle_steps").get_to(p.settle_steps);
    json.at("deposit_seconds").get_to(p.deposit_seconds);
    json.at("settle_seconds").get_to(p.settle_seconds);
    return p;
}

namespace {

/// The deposit in the simulation. @param to_load without a stage to settle in: what is to be dropped comes at once
void deposit(Simulation<2>& simulation, double h, bool to_load, Preparation& report, Progress& progress) {
    const auto& comm = simulation.comm();
    const auto start = std::chrono::steady_clock::now();
    std::vector<GrainRow<2>> grains;
    std::string error;
    if (comm.is_root()) {
        try {
            grains = initial_grains(simulation.scene());
        } catch (const InputError& e) {
            error = e.what();
        }
    }
    comm.throw_together<InputError>(error);
    report.deposit_seconds = seconds_since(start);
    progress.info(fmt::format("deposited {} grains in {:.2f} s", grains.size(), report.deposit_seconds));
    simulation.load(to_load ? with_dropped(comm, simulation.scene(), std::move(grains)) : grains, {}, h);
}

} // namespace

Preparation prepare(Simulation<2>& simulation, const std::filesystem::path& store, Progress& progress,
                    Checkpointer& checkpointer, const nlohmann::ordered_json* course,
                    const std::function<void(nlohmann::ordered_json&)>& remember) {
    const auto& scene = simulation.scene();
    const auto& comm = simulation.comm();
    Preparation report;
    int n_settling = 0;
    while (n_settling < static_cast<int>(scene.stages.size()) &&
           scene.stages[static_cast<std::size_t>(n_settling)].until) {
        ++n_settling;
    }
    const int last = n_settling > 0 ? n_settling - 1 : 0;
    const auto& solver = scene.stages[static_cast<std::size_t>(last)].solver;
    const double h = solver.h / solver.substeps;
    const auto origin = sample_origin(scene, comm.size());
    double settled_before = 0; // seconds, of processes before this one
    int first = 0;
    if (course != nullptr) {
        first = simulation.stage();
        course->at("settle_steps").get_to(report.settle_steps);
        course->at("deposit_seconds").get_to(report.deposit_seconds);
        course->at("settle_seconds").get_to(settled_before);
    } else if (n_settling > 0) {
        const auto found = load_sample<2>(comm, store, origin, row_limits(scene));
        if (found.sample) {
            progress.info(fmt::format("settled sample: {} reused", sample_path(store, origin).string()));
            simulation.load(with_dropped(comm, scene, found.sample->grains), found.sample->contacts, h);
            check_probes(simulation);
            report.reused = true;
            return report;
        }
        progress.info("settled sample: to be made (" + found.reason + ")");
    }
    if (course == nullptr) {
        deposit(simulation, h, n_settling == 0, report, progress);
        check_probes(simulation, n_settling == 0 ? 0 : n_dropped(scene));
    }
    if (n_settling == 0) {
        return report;
    }
    const auto start = std::chrono::steady_clock::now();
    for (int stage = first; stage < n_settling; ++stage) {
        settle(simulation, stage, course != nullptr && stage == first, progress, checkpointer, [&] {
            nlohmann::ordered_json now{{"loading", false},
                                       {"settle_steps", report.settle_steps},
                                       {"deposit_seconds", report.deposit_seconds},
                                       {"settle_seconds", settled_before + seconds_since(start)}};
            remember(now);
            return checkpointer.write(now, {{"stage", scene.stages[static_cast<std::size_t>(stage)].name},
                                            {"step", simulation.stage_steps()},
                                            {"time", simulation.time()}});
        });
        report.settle_steps += simulation.stage_steps();
    }
    store_sample<2>(comm, store, origin, simulation.grain_rows(), simulation.contact_rows(),
                    {{"settle_steps", report.settle_steps}});
    const auto stored = load_sample<2>(comm, store, origin, row_limits(scene));
    if (!stored.sample) {
        throw SystemError(fmt::format("{}: the sample just stored can not be read back ({}); check the disk",
                                      sample_path(store, origin).string(), stored.reason));
    }
    simulation.load(with_dropped(comm, scene, stored.sample->grains), stored.sample->contacts, h);
    report.settle_seconds = settled_before + seconds_since(start);
    return report;
}

} // namespace nappe
