#pragma once
// Where the time of a step goes. Never influences a result.

#include <array>
#include <chrono>
#include <cstddef>

namespace nappe {

/// The stages of a step and of what surrounds it, as docs/architecture.md names them.
enum class Timed : int {
    prepare,
    rebuild,
    predict,
    geometry,
    sweep,
    exchange,
    residual,
    integrate,
    check,
    measure,
    output,
    count
};

inline constexpr std::size_t n_timed = static_cast<std::size_t>(Timed::count);
inline constexpr std::array<const char*, n_timed> timed_names = {"prepare", "rebuild",  "predict",  "geometry",
                                                                 "sweep",   "exchange", "residual", "integrate",
                                                                 "check",   "measure",  "output"};

/// Seconds per stage on this rank.
class Stopwatch {
public:
    /// Adds the time until it goes out of scope.
    class Lap {
    public:
        Lap(Stopwatch& watch, Timed stage) : watch_(watch), stage_(stage), start_(Clock::now()) {}
        ~Lap() {
            watch_.seconds_[static_cast<std::size_t>(stage_)] +=
                std::chrono::duration<double>(Clock::now() - start_).count();
        }
        Lap(const Lap&) = delete;
        Lap& operator=(const Lap&) = delete;

    private:
        using Clock = std::chrono::steady_clock;
        Stopwatch& watch_;
        Timed stage_;
        Clock::time_point start_;
    };

    Lap lap(Timed stage) { return Lap(*this, stage); }
    const std::array<double, n_timed>& seconds() const { return seconds_; }
    void clear() { seconds_.fill(0); }

private:
    std::array<double, n_timed> seconds_{};
};

} // namespace nappe
