#include "commands/recorder.hpp"

#include "core/contact_geometry.hpp"
#include "core/error.hpp"
#include "core/no_value.hpp"
#include "core/stress.hpp"
#include "io/atomic_file.hpp"
#include "solver/smooth_energy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>
#include <span>

namespace nappe {

Recorder::Recorder(Simulation<2>& simulation, const std::filesystem::path& folder, const nlohmann::ordered_json* state)
    : simulation_(simulation), folder_(folder), index_(folder, 2) {
    const auto& comm = simulation.comm();
    if (comm.is_root()) {
        open_series(state);
    }
    sensors_.emplace(simulation, folder, state != nullptr ? &state->at("sensors") : nullptr,
                     state != nullptr ? &state->at("series") : nullptr);
    share_errors();
    if (state != nullptr) {
        resume(*state);
    }
    if (simulation.scene().output.measures.during_run) {
        measurer_.emplace(comm, simulation.scene(), folder / "measures");
        measure_again();
    }
}

void Recorder::open_series(const nlohmann::ordered_json* state) {
    const auto open = [&](const std::string& name, const std::vector<std::string>& columns) {
        const auto path = folder_ / "series" / (name + ".csv");
        return state != nullptr ? SeriesWriter(path, columns, state->at("series").at(name).get<std::int64_t>())
                                : SeriesWriter(path, columns);
    };
    const auto& scene = simulation_.scene();
    for (const auto& cell : scene.output.cells) {
        series_.cells.push_back(open("cell-" + cell.name, {"p", "q", "lambda_x", "lambda_y", "grains"}));
    }
    for (const auto& wall : scene.walls) {
        series_.walls.push_back(open("wall-" + wall.name, {"x", "y", "vx", "vy", "fx", "fy"}));
    }
    series_.front = std::make_unique<SeriesWriter>(open("front", {"front"}));
    std::vector<std::string> energy{"kinetic", "potential", "wall_work"};
    if (scene.output.measures.energy) {
        energy.insert(energy.end(), {"gravity", "friction", "impact", "cohesion", "theta_term", "error"});
        if (loads_springs(scene)) {
            energy.insert(energy.end(), {"spring", "dashpot", "damping", "elastic"});
        }
    }
    series_.energy = std::make_unique<SeriesWriter>(open("energy", energy));
    series_.solver =
        std::make_unique<SeriesWriter>(open("solver", {"residual", "residual_rms", "sweeps", "overlap_mean",
                                                       "overlap_max", "contacts", "candidates", "rebuilds", "redone"}));
}

void Recorder::begin() {
    write_scene();
    initial_ = cell_shapes(simulation_);
    const auto& output = simulation_.scene().output;
    const double bin = output.bin_for(simulation_.mean_radius());
    bed_ = bin > 0 ? median_height(free_surface(simulation_, bin)) : 0.0;

    // The forces that the settled sample carries, as if of one step.
    auto& sums = simulation_.sums();
    sums.clear();
    sums.gauges().for_each_sum([](ExactSum& sum) { sum.clear(); });
    const auto& set = simulation_.candidates();
    for (const auto& tile : set.counted_tiles()) {
        for (auto c = tile.candidates_begin; c < tile.candidates_end; ++c) {
            const auto g = contact_geometry(simulation_.state(), simulation_.walls(), set.a[c], set.b[c]);
            if (g.applies) {
                const auto r = set.impulse(static_cast<std::size_t>(c));
                sums.add(simulation_.state(), set.a[c], set.b[c], g.n, r.n * g.n + r.t[0] * Vec<2>(-g.n[1], g.n[0]));
            }
        }
        sums.end_tile();
    }
    sums.end_steps(1);
    const auto& settings = simulation_.settings();
    write_row(0, 0.0);
    sensors_->begin(settings.h / settings.substeps);
    share_errors();
}

void Recorder::write_sensors(std::int64_t step, double time, bool all) {
    const auto lap = simulation_.watch().lap(Timed::measure);
    if (sensors_->write(step, time, all)) {
        share_errors();
    }
}

/// The scene as run, so that frames can be measured whatever becomes of the run.
void Recorder::write_scene() {
    std::string error;
    if (simulation_.comm().is_root()) {
        try {
            write_file_atomically(folder_ / "scene.toml", simulation_.scene().text);
        } catch (const SystemError& failure) {
            error = failure.what();
        }
    }
    simulation_.comm().throw_together<SystemError>(error);
}

bool Recorder::row_due(std::int64_t step) const {
    return step % simulation_.scene().output.series_every == 0;
}

void Recorder::write_row(std::int64_t step, double time) {
    const auto lap = simulation_.watch().lap(Timed::measure);
    const auto& comm = simulation_.comm();
    auto& sums = simulation_.sums();
    sums.for_each_sum([&](ExactSum& s) { comm.sum(s.limbs()); });
    const auto& settings = simulation_.settings();
    const double h = settings.h / settings.substeps;
    write_cells(step, time, h);
    write_walls(step, time, h);
    wall_work_ += step > 0 ? sums.wall_work() : 0.0;
    sums.clear();
    write_energy(step, time);

    const auto& output = simulation_.scene().output;
    const double bin = output.bin_for(simulation_.mean_radius());
    const double front = bin > 0 ? front_position(free_surface(simulation_, bin), bed_, 4 * simulation_.mean_radius())
                                 : std::numeric_limits<double>::quiet_NaN();
    overlaps_ = overlaps(simulation_);
    largest_overlap_ = std::max(largest_overlap_, overlaps_.largest);
    if (const auto& of_last = simulation_.last_residual()) {
        largest_residual_ = std::max(largest_residual_, of_last->largest);
    }
    if (comm.is_root()) {
        const auto& residual = simulation_.last_residual();
        const auto& counters = simulation_.counters();
        series_.front->append(step, time, std::array{front + simulation_.scene().origin[0]});
        series_.solver->append(step, time,
                               std::array{residual ? residual->largest : no_value, residual ? residual->rms : no_value,
                                          static_cast<double>(simulation_.last_sweeps()), overlaps_.mean,
                                          overlaps_.largest, static_cast<double>(overlaps_.contacts),
                                          static_cast<double>(overlaps_.candidates),
                                          static_cast<double>(counters.rebuilds),
                                          static_cast<double>(counters.redone_lists + counters.redone_packs)});
    }
    share_errors();
}

void Recorder::write_energy(std::int64_t step, double time) {
    const Energies energy = energies(simulation_);
    std::vector<double> row{energy.kinetic, energy.potential, wall_work_};
    if (step == 0) {
        initial_kinetic_ = energy.kinetic;
    }
    if (simulation_.scene().output.measures.energy) {
        auto sums = simulation_.energy(); // the parts of all ranks are added up in a copy, and go on growing
        sums.for_each_sum([&](ExactSum& s) { simulation_.comm().sum(s.limbs()); });
        const EnergyBudget budget = sums.budget();
        const double error =
            energy.kinetic - initial_kinetic_ - (budget.gravity + budget.theta_term + wall_work_ - budget.lost());
        row.insert(row.end(),
                   {budget.gravity, budget.friction, budget.impact, budget.cohesion, budget.theta_term, error});
        if (loads_springs(simulation_.scene())) {
            row.insert(row.end(), {budget.spring, budget.dashpot, budget.damping, elastic_energy(simulation_)});
        }
    }
    if (simulation_.comm().is_root()) {
        series_.energy->append(step, time, row);
    }
}

void Recorder::write_cells(std::int64_t step, double time, double h) {
    const auto shapes = cell_shapes(simulation_);
    const auto& sums = simulation_.sums();
    if (!simulation_.comm().is_root()) {
        return;
    }
    for (std::size_t k = 0; k < shapes.size(); ++k) {
        // V = grain volume / phi0, phi0 = that volume over the circle's when loading starts: the circle's area, since
        // the set of grains stays the same.
        const double radius = simulation_.scene().output.cells[k].radius;
        const double circle = std::numbers::pi * radius * radius;
        const double phi0 = initial_[k].volume / circle;
        const double volume = phi0 > 0 ? shapes[k].volume / phi0 : circle;
        Eigen::Matrix2d sigma;
        for (int i = 0; i < 2; ++i) {
            for (int j = 0; j < 2; ++j) {
                sigma(i, j) = sums.cell_moment(k, i, j) / (h * static_cast<double>(sums.n_steps()) * volume);
            }
        }
        const auto stress = principal_stress(sigma);
        const auto stretch = [&](int d) {
            return initial_[k].extent[d] > 0 ? shapes[k].extent[d] / initial_[k].extent[d]
                                             : std::numeric_limits<double>::quiet_NaN();
        };
        series_.cells[k].append(
            step, time, std::array{stress.p, stress.q, stretch(0), stretch(1), static_cast<double>(shapes[k].grains)});
    }
}

void Recorder::write_walls(std::int64_t step, double time, double h) {
    const auto& sums = simulation_.sums();
    const auto& walls = simulation_.walls();
    if (!simulation_.comm().is_root()) {
        return;
    }
    for (int w = 0; w < walls.n_walls(); ++w) {
        const auto k = static_cast<std::size_t>(w);
        const Vec<2> force = sums.wall_impulse(k) / (h * static_cast<double>(sums.n_steps()));
        series_.walls[k].append(
            step, time,
            std::array{walls.offset[k][0], walls.offset[k][1], walls.v[k][0], walls.v[k][1], force[0], force[1]});
    }
}

void Recorder::write_frame(std::int64_t step, double time) {
    const auto lap = simulation_.watch().lap(Timed::output);
    Frame<2> frame;
    frame.step = step;
    frame.time = time;
    frame.scene_title = simulation_.scene().title;
    frame.with_bonds = simulation_.contacts().cohesive();
    frame.grains = frame_grains(simulation_);
    frame.contacts = frame_contacts(simulation_);
    for (int w = 0; w < simulation_.walls().n_walls(); ++w) {
        frame.walls.push_back({simulation_.walls().name(w), simulation_.walls().points(w)});
    }
    const auto& comm = simulation_.comm();
    auto block = in_blocks(comm, std::move(frame));
    shift(block, simulation_.scene().origin);
    const auto counts = nappe::write_frame(comm, folder_ / frame_name(step), block);
    index_.add(comm, {time, frame_name(step), counts.n_grains, counts.n_contacts});
    frame_steps_.push_back(step);
    if (measurer_) {
        measurer_->measure(std::move(block));
    }
}

void Recorder::share_errors() {
    std::string error;
    for_each_series([&](const std::string&, const SeriesWriter& writer) {
        if (error.empty()) {
            error = writer.error();
        }
    });
    simulation_.comm().throw_together<SystemError>(error);
}

void Recorder::finish() {
    const auto lap = simulation_.watch().lap(Timed::output);
    for_each_series([](const std::string&, SeriesWriter& writer) { writer.finish(); });
    share_errors();
    if (measurer_) {
        measurer_->finish();
    }
}

} // namespace nappe
