#pragma once
// Timings scatter, so they are reported as median and quartiles; and a clock.

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

namespace nappe {

struct Quartiles {
    double low = 0, median = 0, high = 0;
};

/// Quartiles with linear interpolation between the sorted values; zeros if there are none.
inline Quartiles quartiles(std::vector<double> values) {
    if (values.empty()) {
        return {};
    }
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
        const double place = share * static_cast<double>(values.size() - 1);
        const auto below = static_cast<std::size_t>(place);
        const auto above = std::min(below + 1, values.size() - 1);
        return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
    };
    return {at(0.25), at(0.5), at(0.75)};
}

/// values[k] / under[k] of each round, so that what slowed a whole round cancels. Pre: equal lengths.
inline std::vector<double> ratios(const std::vector<double>& values, const std::vector<double>& under) {
    std::vector<double> quotients;
    for (std::size_t k = 0; k < values.size(); ++k) {
        quotients.push_back(under[k] > 0 ? values[k] / under[k] : 0.0);
    }
    return quotients;
}

/// Of what is done once [s].
template <class F>
double seconds_of(F&& f) {
    const auto start = std::chrono::steady_clock::now();
    f();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

} // namespace nappe
