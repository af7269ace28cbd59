#include "commands/checkpointer.hpp"

#include "commands/signals.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace nappe {

namespace {

double steady_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

[[noreturn]] void refuse_policy(const std::string& text) {
    throw InputError(fmt::format("--checkpoint-every: must be a number of steps, a time or both (500, 10min, 90s, 2h, "
                                 "500,10min) or never, found \"{}\"; write 5min for five minutes, 5 for five steps",
                                 text));
}

/// A whole part of the policy; false: it is none.
bool read_part(std::string_view part, CheckpointPolicy& policy) {
    double value = 0;
    const char* const end = part.data() + part.size();
    const auto [rest, error] = std::from_chars(part.data(), end, value);
    const std::string_view unit(rest, static_cast<std::size_t>(end - rest));
    if (error != std::errc() || !(value > 0) || !(value <= 1e12)) {
        return false;
    }
    if (unit.empty()) {
        policy.steps = std::llround(value);
        return policy.steps > 0 && static_cast<double>(policy.steps) == value;
    }
    const double scale = unit == "s" ? 1 : unit == "min" ? 60 : unit == "h" ? 3600 : 0;
    policy.seconds = value * scale;
    return scale > 0;
}

} // namespace

CheckpointPolicy parse_checkpoint_policy(const std::string& text) {
    CheckpointPolicy policy{0, 0};
    if (text == "never") {
        return policy;
    }
    const auto comma = text.find(',');
    const auto first = std::string_view(text).substr(0, comma);
    CheckpointPolicy one{0, 0}, other{0, 0};
    if (!read_part(first, one) ||
        (comma != std::string::npos && !read_part(std::string_view(text).substr(comma + 1), other)) ||
        (one.steps > 0 && other.steps > 0) || (one.seconds > 0 && other.seconds > 0)) {
        refuse_policy(text);
    }
    return {one.steps + other.steps, one.seconds + other.seconds};
}

double parse_wall_time(const std::string& text) {
    int parts[3] = {0, 0, 0};
    const char* at = text.data();
    const char* const end = at + text.size();
    bool good = true;
    for (int k = 0; k < 3 && good; ++k) {
        const auto [rest, error] = std::from_chars(at, end, parts[k]);
        good = error == std::errc() && parts[k] >= 0 && (k == 0 || parts[k] < 60) && rest != at &&
               (k < 2 ? rest != end && *rest == ':' : rest == end);
        at = k < 2 && good ? rest + 1 : rest;
    }
    const double seconds = 3600.0 * parts[0] + 60.0 * parts[1] + parts[2];
    if (!good || seconds == 0) {
        throw InputError(
            fmt::format("--wall-time: must be HH:MM:SS, more than nothing, found \"{}\"; 01:30:00 is an hour "
                        "and a half",
                        text));
    }
    return seconds;
}

Checkpointer::Checkpointer(Simulation<2>& simulation, Progress& progress, std::filesystem::path folder,
                           std::uint64_t key, const CheckpointSettings& settings, std::int64_t first,
                           std::function<double()> now)
    : simulation_(simulation), progress_(progress), folder_(std::move(folder)), key_(key), settings_(settings),
      now_(now ? std::move(now) : steady_seconds), started_(now_()), last_time_(started_), next_(first) {}

std::uint32_t Checkpointer::wishes() {
    const double now = now_();
    if (step_started_ > 0) {
        longest_step_ = std::max(longest_step_, now - step_started_);
    }
    step_started_ = now;
    std::uint32_t bits = signal_came() ? stop_bit : 0;
    // The root's clock counts for all.
    if (simulation_.comm().is_root()) {
        if (settings_.policy.seconds > 0 && now - last_time_ >= settings_.policy.seconds) {
            bits |= due_bit;
        }
        if (settings_.at_once && !never() && written_ + failed_ == 0) {
            bits |= due_bit;
        }
        // Twice what a step and a checkpoint took so far must still fit in.
        const double needed = 2 * (longest_step_ + longest_write_);
        if (settings_.wall_time && now - started_ + needed >= *settings_.wall_time) {
            bits |= stop_bit;
        }
    }
    return bits;
}

bool Checkpointer::write(const nlohmann::ordered_json& course, const nlohmann::ordered_json& notes) {
    if (is_in_last()) {
        return true;
    }
    const double begun = now_();
    const auto& comm = simulation_.comm();
    bool good = false;
    try {
        const auto lap = simulation_.watch().lap(Timed::output);
        Checkpoint<2> checkpoint{next_,  key_, comm.size(), simulation_.scene().text, simulation_.snapshot(),
                                 course, notes};
        store_checkpoint(comm, folder_, std::move(checkpoint));
        good = true;
    } catch (const SystemError& e) { // thrown by all ranks alike
        ++failed_;
        progress_.warning(fmt::format("no checkpoint: {}; {}", e.what(),
                                      last_ > 0 ? fmt::format("{} stands", checkpoint_path(folder_, last_).string())
                                                : std::string("there is none yet")));
    }
    const double now = now_();
    last_time_ = now;
    step_started_ = 0; // its time is no step's
    longest_write_ = std::max(longest_write_, now - begun);
    seconds_ += now - begun;
    if (good) {
        prune(next_);
        ++written_;
        ++next_;
    }
    return good;
}

/// Keeps the newest and the good one before it.
void Checkpointer::prune(std::int64_t newest) {
    if (simulation_.comm().is_root()) {
        for (const auto serial : checkpoint_serials(folder_)) {
            if (serial != newest && serial != last_) {
                remove_checkpoint(folder_, serial);
            }
        }
        std::error_code unknown;
        bytes_ = std::filesystem::file_size(checkpoint_path(folder_, newest), unknown);
    }
    last_ = newest;
}

} // namespace nappe
