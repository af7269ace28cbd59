#pragma once
// What a run has cost so far, over all its restarts.

#include "solver/simulation.hpp"

#include <nlohmann/json.hpp>

#include <array>

namespace nappe {

/// Sums and maxima over ranks; the same on all.
struct RunTotals {
    std::int64_t relaxations = 0;
    std::int64_t messages = 0;
    std::int64_t message_bytes = 0;
    double sweeping = 0;                    ///< by all ranks, the exchange in it too [s]
    std::array<double, n_timed> by_stage{}; ///< on the slowest rank; sweeping without the exchange [s]
    double all = 0;                         ///< [s]
    double loading = 0;                     ///< [s]
    std::int64_t checkpoints = 0;           ///< written
    double writing = 0;                     ///< checkpoints, on the slowest rank [s]
    std::int64_t restarts = 0;

    RunTotals& operator+=(const RunTotals& o);

    /// Calls f(name, number) for every field: the one list that storing and loading go by.
    template <class F>
    void for_each(F&& f) {
        f("relaxations", relaxations);
        f("messages", messages);
        f("message_bytes", message_bytes);
        f("sweeping", sweeping);
        for (std::size_t k = 0; k < n_timed; ++k) {
            f(timed_names[k], by_stage[k]);
        }
        f("all", all);
        f("loading", loading);
        f("checkpoints", checkpoints);
        f("writing", writing);
        f("restarts", restarts);
    }
};

nlohmann::ordered_json to_json(RunTotals totals);

/// Throws nlohmann's exceptions.
RunTotals totals_from(const nlohmann::ordered_json& json);

/// **Collective.** Of this process: stages, relaxations and messages; the rest is the caller's.
RunTotals totals_of(Simulation<2>& simulation);

} // namespace nappe
