#pragma once
// The loading stages of a run, step by step, with all that is written meanwhile.

#include "commands/checkpointer.hpp"
#include "commands/recorder.hpp"

#include <functional>
#include <optional>

namespace nappe {

/// How far loading has come.
struct Course {
    std::int64_t steps = 0;
    double time = 0; ///< [s]
    bool stopped = false;
    bool kept = false; ///< stopped, and there is a checkpoint of it
};

/// Steps of all loading stages. Local.
std::int64_t loading_steps(const Scene<2>& scene);

class Loading {
public:
    /// Local. All must outlive the object. @param limit steps at most
    /// @param remember(course) completes what a checkpoint holds
    Loading(Simulation<2>& simulation, Recorder& recorder, Checkpointer& checkpointer, Progress& progress,
            std::optional<std::int64_t> limit, std::function<void(nlohmann::ordered_json&)> remember);

    /// **Collective.** From step 0, or on from `begun` steps, where simulation and recorder have been resumed, to the last or
    /// until the run is to stop. Throws what steps and files throw.
    Course go(std::optional<std::int64_t> begun);

private:
    void go_through(int stage, bool resumed);
    void write_due(std::uint32_t agreed);
    bool keep();

    Simulation<2>& simulation_;
    Recorder& recorder_;
    Checkpointer& checkpointer_;
    Progress& progress_;
    std::function<void(nlohmann::ordered_json&)> remember_;
    std::int64_t whole_ = 0; ///< steps of the scene
    std::int64_t last_ = 0;  ///< step to end with
    Course course_;
};

} // namespace nappe
