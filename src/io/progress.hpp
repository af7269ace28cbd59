#pragma once
// What a user sees while a run goes on: on a terminal one line that is redrawn; in a log that is not a terminal a line
// now and then. Log messages go through the same object, so that the two do not write over each other. Local, rank 0.

#include <cstdint>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>

#include <spdlog/fwd.h>

namespace nappe {

class Progress {
public:
    struct Settings {
        bool enabled = true;         ///< false on every rank but 0: then nothing is ever shown
        bool terminal = false;       ///< redraw one line
        std::FILE* out = nullptr;    ///< stderr if null
        std::function<double()> now; ///< seconds of a steady clock; tests give their own
    };

    /// Settings for a rank: enabled on the root, terminal if stderr is one.
    static Settings for_rank(bool is_root);

    explicit Progress(Settings settings);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// n_steps: of the stage; 0 if it ends by a criterion, then no time left is shown. done: those that were done before.
    void begin_stage(const std::string& name, std::int64_t n_steps, std::int64_t done = 0);
    /// After each step; cheap. step: within the stage. time: simulated [s].
    void update(std::int64_t step, double time);
    /// Leaves a last line with the stage's mean rate.
    void end_stage();

    /// A message with its time, through spdlog.
    void info(const std::string& text);
    void warning(const std::string& text);

private:
    void show(double now, bool last);
    void log(int level, const std::string& text);
    /// Wipes the line that is being redrawn, so that something else can be printed.
    void clear_line();
    double interval(double elapsed) const;

    Settings settings_;
    std::shared_ptr<spdlog::logger> logger_;
    std::string stage_;
    std::int64_t n_steps_ = 0;
    std::int64_t step_ = 0;
    std::int64_t first_step_ = 0;
    double time_ = 0;
    double started_ = 0;
    double shown_ = 0;
    std::int64_t shown_step_ = 0;
    double rate_ = 0; ///< [steps/s], smoothed
    bool drawn_ = false;
};

/// "push 1250/20000 (6 %), t = 31.25 s, 5.6 steps/s, 55 min left". n_steps and rate 0: unknown, left out.
std::string format_progress(const std::string& stage, std::int64_t step, std::int64_t n_steps, double time,
                            double rate);

/// "45 s", "12 min", "3 h 20 min". seconds >= 0
std::string format_duration(double seconds);

} // namespace nappe
