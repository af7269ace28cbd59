#pragma once
// What `nappe trade` concludes from numbers. Everything is Local; docs/accuracy.md has the definitions.

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace nappe {

enum class Verdict {
    within,  ///< the mean difference is no larger than chance alone makes it, one time in twenty
    differs, ///< it is larger
    unknown, ///< fewer than two seeds have both values: no scatter is known
    absent,  ///< no seed has both values
};

/// "within the scatter", "differs", "no scatter known", "not measured".
std::string_view verdict_text(Verdict verdict);

/// An observable of a setting beside that of the reference, seed by seed. NaN where there is nothing to say.
struct Comparison {
    std::size_t n = 0;             ///< seeds that have both values; the others are left out of all that follows
    double mean = 0;               ///< of the setting
    double reference = 0;          ///< mean of the reference
    double difference = 0;         ///< mean of setting - reference, seed by seed
    double standard_error = 0;     ///< of that mean
    double scatter = 0;            ///< standard deviation of the reference over its seeds
    double over_scatter = 0;       ///< difference / the larger of scatter and resolution; 0 if the difference is 0
    double error_over_scatter = 0; ///< the same of the standard error
    Verdict verdict = Verdict::absent;
};

/// Both spans: one value a seed, in the same order; NaN where a run has none.
/// @param resolution least scatter that can be told: what is rounded to bins may not scatter at all
Comparison compare(std::span<const double> setting, std::span<const double> reference, double resolution = 0);

/// 97.5 % quantile of Student's distribution, to 0.1 %: |mean| beyond this many standard errors is chance one time in
/// twenty. (A plain 2 would call one agreement in twelve a difference with 8 seeds, three in ten with 2.)
/// @param degrees of freedom, >= 1
double student_quantile(std::size_t degrees);

/// Root mean square of the numbers among `values` that are finite; NaN if there are none.
double root_mean_square(std::span<const double> values);

struct TradePoint {
    double cost = 0, error = 0;
};

/// Whether no other point is as good in both and better in one. A point that is not finite is never on the front.
std::vector<bool> pareto_front(std::span<const TradePoint> points);

} // namespace nappe
