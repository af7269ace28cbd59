// Runs to rows: seeds put together, compared with the reference, fronts marked.
#include "commands/trade_report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nappe {

namespace {

using Results = std::vector<TradeResult>;

const TradeResult* find(const Results& results, std::size_t setting, std::size_t seed) {
    for (const auto& result : results) {
        if (result.setting == setting && result.seed == seed) {
            return &result;
        }
    }
    return nullptr;
}

/// By seed; NaN where there is no run, or no value in it.
std::vector<double> values_of(const Results& results, std::size_t setting, std::size_t observable,
                              std::size_t n_seeds) {
    std::vector<double> values(n_seeds, std::numeric_limits<double>::quiet_NaN());
    for (std::size_t s = 0; s < n_seeds; ++s) {
        if (const auto* result = find(results, setting, s); result != nullptr && result->figures) {
            values[s] = result->figures->observables[observable].value;
        }
    }
    return values;
}

std::vector<Observable> observables_of(const Results& results) {
    for (const auto& result : results) {
        if (result.figures) {
            return result.figures->observables;
        }
    }
    return {};
}

TradeRow row_of(const TradePlan& plan, const Results& results, std::size_t setting) {
    TradeRow row;
    row.name = plan.names[setting];
    std::vector<TradeFigures> figures;
    for (std::size_t s = 0; s < plan.seeds.size(); ++s) {
        const auto* result = find(results, setting, s);
        if (result != nullptr && result->figures) {
            figures.push_back(result->figures->figures);
        } else if (result != nullptr && !result->failure.empty()) {
            row.failure = row.n_failed++ == 0 ? result->failure : row.failure;
        }
    }
    row.n_runs = figures.size();
    row.figures = over_seeds(figures);
    auto observables = observables_of(results);
    std::vector<double> errors, noises;
    for (std::size_t k = 0; k < observables.size(); ++k) {
        const auto comparison = compare(values_of(results, setting, k, plan.seeds.size()),
                                        values_of(results, 0, k, plan.seeds.size()), observables[k].resolution);
        observables[k].value = comparison.mean;
        row.observables.push_back({observables[k], comparison});
        errors.push_back(comparison.over_scatter);
        noises.push_back(comparison.error_over_scatter);
    }
    row.observable_error = root_mean_square(errors);
    row.observable_noise = root_mean_square(noises);
    return row;
}

} // namespace

std::vector<TradeRow> trade_rows(const TradePlan& plan, const Results& results) {
    std::vector<TradeRow> rows;
    for (std::size_t k = 0; k < plan.names.size(); ++k) {
        rows.push_back(row_of(plan, results, k));
    }
    std::size_t most = 0; // what a seed costs differs from seed to seed: only settings with equal runs are compared
    for (std::size_t k = 1; k < rows.size(); ++k) {
        most = std::max(most, rows[k].n_runs); // the reference is a run ahead where a matrix was stopped
    }
    const auto mark = [&](double TradeFigures::*cost, auto&& error, bool TradeFronts::*front) {
        std::vector<TradePoint> points;
        for (std::size_t k = 0; k < rows.size(); ++k) {
            const bool judged = k > 0 && rows[k].n_runs == most && rows[k].n_failed == 0;
            points.push_back(
                {judged ? rows[k].figures.*cost : std::numeric_limits<double>::quiet_NaN(), error(rows[k])});
        }
        const auto on_front = pareto_front(points);
        for (std::size_t k = 0; k < rows.size(); ++k) {
            rows[k].fronts.*front = on_front[k];
        }
    };
    const auto overlap = [](const TradeRow& row) { return row.figures.overlap_mean; };
    const auto observables = [](const TradeRow& row) { return row.observable_error; };
    mark(&TradeFigures::relaxations, overlap, &TradeFronts::relaxations_overlap);
    mark(&TradeFigures::relaxations, observables, &TradeFronts::relaxations_observables);
    mark(&TradeFigures::seconds_steps, overlap, &TradeFronts::seconds_overlap);
    mark(&TradeFigures::seconds_steps, observables, &TradeFronts::seconds_observables);
    return rows;
}

std::vector<std::string> as_tight_as_reference(const std::vector<TradeRow>& rows) {
    std::vector<std::string> names;
    const auto& reference = rows.front().figures;
    for (std::size_t k = 1; k < rows.size(); ++k) {
        const auto& f = rows[k].figures;
        if (f.residual_largest <= reference.residual_largest && f.overlap_mean <= reference.overlap_mean) {
            names.push_back(rows[k].name);
        }
    }
    return names;
}

} // namespace nappe
