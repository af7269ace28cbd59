#include "commands/loading.hpp"

#include "commands/watched_step.hpp"

#include <algorithm>

namespace nappe {

std::int64_t loading_steps(const Scene<2>& scene) {
    std::int64_t steps = 0;
    for (const auto& stage : scene.stages) {
        steps += stage.until ? 0 : n_steps(stage);
    }
    return steps;
}

Loading::Loading(Simulation<2>& simulation, Recorder& recorder, Checkpointer& checkpointer, Progress& progress,
                 std::optional<std::int64_t> limit, std::function<void(nlohmann::ordered_json&)> remember)
    : simulation_(simulation), recorder_(recorder), checkpointer_(checkpointer), progress_(progress),
      remember_(std::move(remember)), whole_(loading_steps(simulation.scene())),
      last_(limit ? std::min(whole_, *limit) : whole_) {}

Course Loading::go(std::optional<std::int64_t> begun) {
    const auto& stages = simulation_.scene().stages;
    int first = 0;
    if (begun) {
        course_.steps = *begun;
        course_.time = simulation_.time();
        first = simulation_.stage();
    }
    for (int s = first; s < static_cast<int>(stages.size()) && !course_.stopped; ++s) {
        // A scene that only prepares has its sample written in the last of its stages.
        if (!stages[static_cast<std::size_t>(s)].until || s + 1 == static_cast<int>(stages.size())) {
            go_through(s, begun && s == first);
        }
    }
    return course_;
}

void Loading::go_through(int stage, bool resumed) {
    const auto& settings = simulation_.scene().stages[static_cast<std::size_t>(stage)];
    if (!resumed) {
        const bool begins = !recorder_.begun();
        simulation_.start_stage(stage);
        if (begins) {
            simulation_.mark_cells();
            recorder_.begin();
            recorder_.write_frame(0, 0.0);
        }
    }
    const std::int64_t done = simulation_.stage_steps();
    const std::int64_t n =
        settings.until ? 0 : std::min(n_steps(settings), done + std::max<std::int64_t>(0, last_ - course_.steps));
    progress_.begin_stage(settings.name, n, done);
    for (std::int64_t k = done; k < n && !course_.stopped; ++k) {
        const bool with_residual = recorder_.row_due(course_.steps + 1) || course_.steps + 1 == last_;
        const auto agreed = watched_step(simulation_, with_residual, checkpointer_, progress_, [&] { return keep(); });
        ++course_.steps;
        course_.time = simulation_.time();
        write_due(agreed);
        progress_.update(k + 1, course_.time);
    }
    progress_.end_stage();
}

/// Rows, frames and checkpoints of the step that has just been done. A run that ends before its scene does leaves a row and
/// a frame that the whole run does not have: a checkpoint comes before them.
void Loading::write_due(std::uint32_t agreed) {
    const std::int64_t step = course_.steps;
    const int every = simulation_.scene().output.frames_every;
    const bool ends = step == last_, whole = step == whole_;
    const bool row = recorder_.row_due(step) || whole;
    const bool frame = (every > 0 && step % every == 0) || whole;
    course_.stopped = Checkpointer::stops(agreed) && !ends;
    if (row) {
        recorder_.write_row(step, course_.time);
    }
    recorder_.write_sensors(step, course_.time, whole);
    if (frame) {
        recorder_.write_frame(step, course_.time);
    }
    if (!whole && !checkpointer_.never() && (ends || course_.stopped || checkpointer_.due(agreed, step))) {
        const bool kept = keep();
        course_.kept = course_.stopped && kept;
    }
    if (ends && !row) {
        recorder_.write_row(step, course_.time);
    }
    if (ends && !whole) {
        recorder_.write_sensors(step, course_.time, true);
    }
    if ((ends || course_.stopped) && !frame) {
        recorder_.write_frame(step, course_.time);
    }
}

bool Loading::keep() {
    nlohmann::ordered_json now{{"loading", true}, {"steps", course_.steps}, {"recorder", recorder_.state()}};
    remember_(now);
    return checkpointer_.write(
        now, {{"stage", simulation_.scene().stages[static_cast<std::size_t>(simulation_.stage())].name},
              {"step", course_.steps},
              {"time", course_.time}});
}

} // namespace nappe
