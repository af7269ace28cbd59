#pragma once
// The tables of `nappe trade`: what is concluded from the runs, as CSV, JSON and text. Everything is Local, for rank 0.

#include "commands/trade_figures.hpp"
#include "commands/trade_plan.hpp"
#include "commands/trade_statistics.hpp"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace nappe {

/// What is known of one run.
struct TradeResult {
    std::size_t setting = 0, seed = 0;
    std::optional<RunFigures> figures; ///< of a finished run
    std::string failure;               ///< why it failed; "" if it did not
};

/// Which costs and errors the fronts are drawn for.
struct TradeFronts {
    bool relaxations_overlap = false, relaxations_observables = false;
    bool seconds_overlap = false, seconds_observables = false;
};

/// One setting over all seeds.
struct TradeRow {
    std::string name;
    std::size_t n_runs = 0, n_failed = 0;
    std::string failure; ///< of the first that failed
    TradeFigures figures;
    struct Compared {
        Observable observable; ///< its name and unit; value: the setting's mean
        Comparison comparison;
    };
    std::vector<Compared> observables;
    double observable_error = 0; ///< root mean square over observables of difference / scatter
    double observable_noise = 0; ///< the same of standard error / scatter: what chance leaves of it
    TradeFronts fronts;          ///< the reference stands on none
};

/// One row a setting, the reference first. Figures are over the seeds that are there; a setting that failed with any
/// seed, or lacks runs that others have, is on no front.
std::vector<TradeRow> trade_rows(const TradePlan& plan, const std::vector<TradeResult>& results);

/// Settings whose largest residual and mean overlap are no larger than the reference's: what differs from it may be its
/// error.
std::vector<std::string> as_tight_as_reference(const std::vector<TradeRow>& rows);

/// "done", "failed (1 of 8): why", "3 of 8 seeds".
std::string trade_status(const TradeRow& row, std::size_t n_seeds);

std::string trade_csv(const std::vector<TradeRow>& rows, std::size_t n_seeds);
std::string observables_csv(const std::vector<TradeRow>& rows);
std::string trade_text(const std::vector<TradeRow>& rows, std::size_t n_seeds);

/// All that is known, with each run's own figures.
nlohmann::ordered_json trade_json(const TradePlan& plan, const TradeMatrix& matrix,
                                  const std::vector<TradeResult>& results, const std::vector<TradeRow>& rows);

} // namespace nappe
