#include "solver/watcher.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace nappe {

void Watcher::begin_step() {
    at_start_ = memory_;
    lines_at_start_ = lines_.size();
    found_.fill(false);
}

void Watcher::begin_step_again(int substeps) {
    const bool first = memory_.divided_steps == at_start_.divided_steps;
    const auto divided = memory_.divided_steps + (first ? 1 : 0);
    memory_ = at_start_;
    memory_.divided_steps = divided;
    memory_.most_substeps = std::max<std::int64_t>(memory_.most_substeps, substeps);
    lines_.resize(lines_at_start_);
    found_.fill(false);
}

bool Watcher::count(Watched what) {
    const auto k = static_cast<std::size_t>(what);
    if (found_[k]) {
        return false;
    }
    found_[k] = true;
    const std::int64_t n = ++memory_.steps[k];
    return (n & (n - 1)) == 0;
}

void Watcher::tell(Watched what, const std::string& text) {
    const std::int64_t n = memory_.steps[static_cast<std::size_t>(what)];
    lines_.push_back(n > 1 ? fmt::format("{} ({} such steps so far)", text, n) : text);
}

double Watcher::energy_scale(double now, bool remember) {
    memory_.largest_scale = remember && now > memory_.largest_scale ? now : memory_.largest_scale;
    const double least = 1e-9 * memory_.largest_scale;
    return now > least ? now : least;
}

std::vector<std::string> Watcher::take_lines() {
    std::vector<std::string> lines;
    lines.swap(lines_);
    lines_at_start_ = 0;
    return lines;
}

} // namespace nappe
