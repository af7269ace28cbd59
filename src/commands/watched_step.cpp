#include "commands/watched_step.hpp"

#include "commands/watch_report.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

namespace nappe {

std::uint32_t watched_step(Simulation<2>& simulation, bool with_residual, Checkpointer& checkpointer,
                           Progress& progress, const std::function<bool()>& keep) {
    try {
        const auto agreed = simulation.step(checkpointer.wishes(), with_residual);
        show_watch(simulation, progress);
        return agreed;
    } catch (const NumericalFailure&) { // thrown by all ranks alike
        show_watch(simulation, progress);
        if (!checkpointer.never() && simulation.undo_step() && keep()) {
            const bool preparing =
                simulation.scene().stages[static_cast<std::size_t>(simulation.stage())].until.has_value();
            progress.warning(fmt::format(
                "the state before the step that failed is in a checkpoint: nappe restart {} (--set) goes on from there",
                preparing ? "with another [watch]; what else a sample is prepared by needs the scene run anew"
                          : "with other settings"));
        }
        throw;
    }
}

} // namespace nappe
