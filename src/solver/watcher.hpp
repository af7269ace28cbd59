#pragma once
// The books of the watch (scene section [watch]): what has been found so far, and what the user has not been told yet. Who
// looks, and who is to blame, is the simulation's (watch_step.cpp, watch_energy.cpp, watch_causes.cpp).

#include "core/scene.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace nappe {

/// What may be found in a step that could be taken.
enum class Watched : int { overlap, energy, residual, bounds };
inline constexpr std::size_t n_watched = 4;
inline constexpr std::array<const char*, n_watched> watched_names = {"overlap", "energy", "residual", "bounds"};

/// All that the watch remembers from one step to the next; the same on all ranks. Counted since the sample was loaded.
/// Trivially copyable.
struct WatchMemory {
    std::array<std::int64_t, n_watched> steps{}; ///< in which this was found and let pass
    std::int64_t unconverged_in_row = 0;         ///< steps up to now that ended above the tolerance
    std::int64_t divided_steps = 0;              ///< done again with more substeps
    std::int64_t most_substeps = 0;              ///< that one of them took
    double largest_growth = 0;                   ///< of energy without work, as the limit has it
    double largest_scale = 0;                    ///< energies that growth was compared with [J]
};

/// One contact or grain that is the worst of its kind. Trivially copyable, for Communicator::all_gather.
struct Suspect {
    double measure = -1; ///< what makes it the worst; < 0: there is none
    GlobalId lo = 0, hi = -1;
    int wall = -1;                 ///< the partner, if hi < 0
    std::array<double, 2> place{}; ///< of grain lo, as scenes have it [m]

    /// Worse, or as bad and of a lower id: an order without ties among contacts.
    bool worse_than(const Suspect& other) const {
        if (measure != other.measure) {
            return measure > other.measure;
        }
        if (lo != other.lo) {
            return lo < other.lo;
        }
        return hi != other.hi ? hi < other.hi : wall < other.wall;
    }
};

/// All members are Local and called alike on all ranks.
class Watcher {
public:
    const WatchMemory& memory() const { return memory_; }
    void set_memory(const WatchMemory& memory) { memory_ = memory; }
    void clear() { *this = {}; }

    /// A step begins, or begins again: what it has found so far does not count.
    void begin_step();
    void begin_step_again(int substeps);

    /// Counts a step in which this was found, once a step.
    /// @returns whether the user is to be told: the first time, the second, the fourth, the eighth …
    bool count(Watched what);
    void tell(Watched what, const std::string& text);

    void set_unconverged_in_row(std::int64_t steps) { memory_.unconverged_in_row = steps; }
    /// What growth is compared with, never less than a billionth of what it was at most: where all is at rest, round-off
    /// is no growth [J]. @param remember whether it may become the most
    double energy_scale(double now, bool remember);
    void note_growth(double growth) {
        memory_.largest_growth = growth > memory_.largest_growth ? growth : memory_.largest_growth;
    }

    /// Lines for the user since the last call.
    std::vector<std::string> take_lines();

private:
    WatchMemory memory_;
    WatchMemory at_start_; ///< of the step in hand
    std::array<bool, n_watched> found_{};
    std::vector<std::string> lines_;
    std::size_t lines_at_start_ = 0;
};

} // namespace nappe
