#include "io/progress.hpp"

#include <fmt/format.h>
#include <spdlog/sinks/ansicolor_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <unistd.h>

namespace nappe {

namespace {

constexpr double redraw_every = 0.2; // [s] on a terminal
constexpr double rate_memory = 20;   // [s] over which the rate is smoothed

double steady_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// An spdlog sink that writes to any FILE, in colour on a terminal.
class FileSink : public spdlog::sinks::ansicolor_sink<spdlog::details::console_mutex> {
public:
    FileSink(std::FILE* out, bool terminal)
        : ansicolor_sink(out, terminal ? spdlog::color_mode::always : spdlog::color_mode::never) {}
};

} // namespace

Progress::Settings Progress::for_rank(bool is_root) {
    Settings settings;
    settings.enabled = is_root;
    settings.terminal = ::isatty(STDERR_FILENO) == 1;
    return settings;
}

Progress::Progress(Settings settings) : settings_(std::move(settings)) {
    if (!settings_.out) {
        settings_.out = stderr;
    }
    if (!settings_.now) {
        settings_.now = steady_seconds;
    }
    logger_ = std::make_shared<spdlog::logger>("nappe", std::make_shared<FileSink>(settings_.out, settings_.terminal));
    logger_->set_pattern("[%H:%M:%S] %^%v%$");
    logger_->flush_on(spdlog::level::info);
}

Progress::~Progress() {
    clear_line();
}

void Progress::begin_stage(const std::string& name, std::int64_t n_steps, std::int64_t done) {
    stage_ = name;
    n_steps_ = n_steps;
    step_ = shown_step_ = first_step_ = done;
    rate_ = 0;
    started_ = shown_ = settings_.now();
}

void Progress::update(std::int64_t step, double time) {
    step_ = step;
    time_ = time;
    if (!settings_.enabled) {
        return;
    }
    const double now = settings_.now();
    if (now - shown_ >= interval(now - started_)) {
        show(now, false);
    }
}

void Progress::end_stage() {
    if (!settings_.enabled || stage_.empty()) {
        return;
    }
    show(settings_.now(), true);
    stage_.clear();
}

double Progress::interval(double elapsed) const {
    // In a log: often at first, when a user looks whether all is well, then every twentieth of the time gone by. A run
    // of a minute leaves some lines and one of a day about a hundred, whether or not its length is known.
    return settings_.terminal ? redraw_every : std::clamp(elapsed / 20, 10.0, 600.0);
}

void Progress::show(double now, bool last) {
    const double elapsed = now - shown_;
    if (last) {
        rate_ = now > started_ ? static_cast<double>(step_ - first_step_) / (now - started_) : 0;
    } else if (elapsed > 0) {
        const double recent = static_cast<double>(step_ - shown_step_) / elapsed;
        const double keep = rate_ > 0 ? std::exp(-elapsed / rate_memory) : 0;
        rate_ = keep * rate_ + (1 - keep) * recent;
    }
    shown_ = now;
    shown_step_ = step_;
    if (last) {
        const auto text = format_progress(stage_, step_, 0, time_, rate_);
        info(fmt::format("{}, done in {}", text, format_duration(now - started_)));
    } else if (settings_.terminal) {
        fmt::print(settings_.out, "\r{}\x1b[K", format_progress(stage_, step_, n_steps_, time_, rate_));
        std::fflush(settings_.out);
        drawn_ = true;
    } else {
        info(format_progress(stage_, step_, n_steps_, time_, rate_));
    }
}

void Progress::info(const std::string& text) {
    log(spdlog::level::info, text);
}

void Progress::warning(const std::string& text) {
    log(spdlog::level::warn, "warning: " + text);
}

void Progress::log(int level, const std::string& text) {
    if (settings_.enabled) {
        clear_line();
        logger_->log(static_cast<spdlog::level::level_enum>(level), "{}", text);
    }
}

void Progress::clear_line() {
    if (drawn_) {
        fmt::print(settings_.out, "\r\x1b[K");
        std::fflush(settings_.out);
        drawn_ = false;
    }
}

std::string format_progress(const std::string& stage, std::int64_t step, std::int64_t n_steps, double time,
                            double rate) {
    std::string text = n_steps > 0 ? fmt::format("{} {}/{} ({} %)", stage, step, n_steps, 100 * step / n_steps)
                                   : fmt::format("{} {} steps", stage, step);
    text += fmt::format(", t = {:.6g} s", time);
    if (rate > 0) {
        text += fmt::format(", {:.3g} steps/s", rate);
        if (n_steps > 0) {
            text +=
                ", " + format_duration(static_cast<double>(std::max<std::int64_t>(0, n_steps - step)) / rate) + " left";
        }
    }
    return text;
}

std::string format_duration(double seconds) {
    if (seconds < 90) {
        return fmt::format("{:.0f} s", seconds);
    }
    const auto minutes = static_cast<std::int64_t>(std::min(std::round(seconds / 60), 1e12));
    return minutes < 60 ? fmt::format("{} min", minutes) : fmt::format("{} h {} min", minutes / 60, minutes % 60);
}

} // namespace nappe
