#include "commands/trade_statistics.hpp"

#include "core/error.hpp"
#include "core/no_value.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace nappe {

namespace {

double plain_mean(const std::vector<double>& values) {
    double sum = 0;
    for (const double v : values) {
        sum += v;
    }
    return sum / static_cast<double>(values.size());
}

/// Of a sample: with n - 1.
double deviation_of(const std::vector<double>& values) {
    const double mean = plain_mean(values);
    double sum = 0;
    for (const double v : values) {
        sum += (v - mean) * (v - mean);
    }
    return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

} // namespace

std::string_view verdict_text(Verdict verdict) {
    constexpr std::array<std::string_view, 4> texts = {"within the scatter", "differs", "no scatter known",
                                                       "not measured"};
    return texts[static_cast<std::size_t>(verdict)];
}

Comparison compare(std::span<const double> setting, std::span<const double> reference, double resolution) {
    NAPPE_ASSERT(setting.size() == reference.size(), std::to_string(setting.size()));
    std::vector<double> ours, theirs, differences;
    for (std::size_t s = 0; s < setting.size(); ++s) {
        if (std::isfinite(setting[s]) && std::isfinite(reference[s])) {
            ours.push_back(setting[s]);
            theirs.push_back(reference[s]);
            differences.push_back(setting[s] - reference[s]);
        }
    }
    Comparison c{ours.size(), no_value, no_value, no_value, no_value, no_value, no_value, no_value, Verdict::absent};
    if (c.n == 0) {
        return c;
    }
    c.mean = plain_mean(ours);
    c.reference = plain_mean(theirs);
    c.difference = plain_mean(differences);
    c.verdict = Verdict::unknown;
    if (c.n == 1) {
        return c;
    }
    c.standard_error = deviation_of(differences) / std::sqrt(static_cast<double>(c.n));
    c.scatter = deviation_of(theirs);
    const double unit = std::max(c.scatter, resolution);
    const auto in_units = [&](double value) { return value == 0 ? 0.0 : unit > 0 ? value / unit : no_value; };
    c.over_scatter = in_units(c.difference);
    c.error_over_scatter = in_units(c.standard_error);
    c.verdict =
        std::abs(c.difference) > student_quantile(c.n - 1) * c.standard_error ? Verdict::differs : Verdict::within;
    return c;
}

double student_quantile(std::size_t degrees) {
    constexpr std::array<double, 10> exact = {12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228};
    // Beyond, Cornish and Fisher's series about the normal distribution's z = 1.960:
    // z + (z³ + z)/(4 n) + (5 z⁵ + 16 z³ + 3 z)/(96 n²), right to 0.1 % from n = 11 on.
    const auto n = static_cast<double>(degrees);
    return degrees <= exact.size() ? exact[std::max<std::size_t>(degrees, 1) - 1] : 1.960 + 2.372 / n + 2.823 / (n * n);
}

double root_mean_square(std::span<const double> values) {
    double sum = 0;
    int n = 0;
    for (const double v : values) {
        if (std::isfinite(v)) {
            sum += v * v;
            ++n;
        }
    }
    return n > 0 ? std::sqrt(sum / n) : no_value;
}

std::vector<bool> pareto_front(std::span<const TradePoint> points) {
    const auto finite = [](const TradePoint& p) { return std::isfinite(p.cost) && std::isfinite(p.error); };
    std::vector<bool> front;
    for (const auto& p : points) {
        front.push_back(finite(p) && std::none_of(points.begin(), points.end(), [&](const TradePoint& other) {
                            return finite(other) && other.cost <= p.cost && other.error <= p.error &&
                                   (other.cost < p.cost || other.error < p.error);
                        }));
    }
    return front;
}

} // namespace nappe
