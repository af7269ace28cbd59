#pragma once
// When a run writes a checkpoint, and when it stops by itself.

#include "io/checkpoint_store.hpp"
#include "io/progress.hpp"
#include "solver/simulation.hpp"

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>

namespace nappe {

/// How often, by steps and by minutes, whichever comes first.
struct CheckpointPolicy {
    std::int64_t steps = 0; ///< 0: steps do not count
    double seconds = 600;   ///< 0: time does not count

    bool never() const { return steps == 0 && seconds == 0; }
};

/// "500", "10min", "500,10min", "90s", "2h", "never". Local. Throws InputError.
CheckpointPolicy parse_checkpoint_policy(const std::string& text);

/// "HH:MM:SS" in seconds. Local. Throws InputError.
double parse_wall_time(const std::string& text);

struct CheckpointSettings {
    CheckpointPolicy policy;
    std::optional<double> wall_time; ///< [s] since the run began, after MPI did: the run ends itself before
    bool at_once = false;            ///< after the first step, too
};

/// Asked before each step for what it wishes of all ranks, and after it what they agreed on. Signals, clocks and the disk
/// decide when a checkpoint is written; no bit of a result follows from that.
class Checkpointer {
public:
    /// Local. Both references must outlive the object. @param first serial of the next checkpoint
    /// @param now seconds of a steady clock; tests give their own
    Checkpointer(Simulation<2>& simulation, Progress& progress, std::filesystem::path folder, std::uint64_t key,
                 const CheckpointSettings& settings, std::int64_t first = 1, std::function<double()> now = {});

    /// Local. Bits for Simulation::step: a signal has come, wall time is nearly over, a checkpoint is due by the clock. To be
    /// called once before each step.
    std::uint32_t wishes();

    /// Local. What the step returned: whether the run is to stop after it.
    static bool stops(std::uint32_t agreed) { return (agreed & stop_bit) != 0; }

    /// Local. Whether a checkpoint is due after this step of the stage or of loading.
    bool due(std::uint32_t agreed, std::int64_t step) const {
        const auto& policy = settings_.policy;
        return (agreed & due_bit) != 0 || (policy.steps > 0 && step > 0 && step % policy.steps == 0);
    }

    /// **Collective.** Writes one and takes away all but the last two. If that fails, the log says so, the run goes on, and
    /// the next is tried when it is due. Returns whether it is written.
    /// @param course, notes see Checkpoint
    bool write(const nlohmann::ordered_json& course, const nlohmann::ordered_json& notes);

    /// Local. The run goes on from this one: it is kept as the last but one, and not written again until there was a step.
    void keep(std::int64_t serial) {
        last_ = serial;
        went_on_from_ = now_in();
    }

    bool never() const { return settings_.policy.never(); }
    bool any() const { return last_ > 0; }            ///< whether there is one to go on from
    std::int64_t written() const { return written_; } ///< by this process
    std::int64_t failed() const { return failed_; }
    double seconds() const { return seconds_; } ///< spent writing, on this rank
    std::uintmax_t bytes() const { return bytes_; }

private:
    static constexpr std::uint32_t stop_bit = flag::outside_first;
    static constexpr std::uint32_t due_bit = flag::outside_first << 1;

    void prune(std::int64_t newest);
    bool is_in_last() const { return written_ == 0 && !settings_.at_once && now_in() == went_on_from_; }
    std::pair<int, std::int64_t> now_in() const { return {simulation_.stage(), simulation_.stage_steps()}; }

    Simulation<2>& simulation_;
    Progress& progress_;
    std::filesystem::path folder_;
    std::uint64_t key_;
    CheckpointSettings settings_;
    std::function<double()> now_;
    double started_ = 0;      ///< of the run [s]
    double last_time_ = 0;    ///< of the last checkpoint
    double step_started_ = 0; ///< 0: none yet
    double longest_step_ = 0;
    double longest_write_ = 0;
    std::int64_t next_ = 1;
    std::int64_t last_ = 0;                             ///< newest that is known to be good; 0: none
    std::pair<int, std::int64_t> went_on_from_{-1, -1}; ///< stage and its steps
    std::int64_t written_ = 0, failed_ = 0;
    double seconds_ = 0;
    std::uintmax_t bytes_ = 0; ///< of the last
};

} // namespace nappe
