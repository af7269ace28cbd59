#include "core/measures/line_fit.hpp"

#include "core/no_value.hpp"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>

namespace nappe {

namespace {

/// Coefficients of a polynomial of (at - middle) / scale, or nothing if the points do not determine it.
template <int Terms>
struct Polynomial {
    bool found = false;
    double middle = 0, scale = 1;
    Eigen::Matrix<double, Terms, 1> c;
    double residual = 0; ///< root mean square
};

template <int Terms>
Polynomial<Terms> fit(std::span<const FitPoint> points) {
    Polynomial<Terms> p;
    if (points.size() <= Terms) {
        return p;
    }
    const auto [low, high] =
        std::minmax_element(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.at < b.at; });
    p.middle = (low->at + high->at) / 2;
    p.scale = high->at > low->at ? (high->at - low->at) / 2 : 1.0;
    const auto n = static_cast<Eigen::Index>(points.size());
    Eigen::Matrix<double, Eigen::Dynamic, Terms> powers(n, Terms);
    Eigen::VectorXd values(n);
    for (Eigen::Index k = 0; k < n; ++k) {
        const auto& point = points[static_cast<std::size_t>(k)];
        powers(k, 0) = 1;
        for (int t = 1; t < Terms; ++t) {
            powers(k, t) = powers(k, t - 1) * (point.at - p.middle) / p.scale;
        }
        values[k] = point.value;
    }
    const auto decomposed = powers.colPivHouseholderQr();
    p.found = decomposed.rank() == Terms;
    if (p.found) {
        p.c = decomposed.solve(values);
        p.residual = std::sqrt((powers * p.c - values).squaredNorm() / static_cast<double>(n));
    }
    return p;
}

/// Median of the slopes between all pairs of points, which a quarter of wild points does not move far.
double median_slope(std::span<const FitPoint> points) {
    std::vector<double> slopes;
    for (std::size_t a = 0; a < points.size(); ++a) {
        for (std::size_t b = a + 1; b < points.size(); ++b) {
            if (points[a].at != points[b].at) {
                slopes.push_back((points[b].value - points[a].value) / (points[b].at - points[a].at));
            }
        }
    }
    return median(std::move(slopes));
}

} // namespace

double median(std::vector<double> values) {
    if (values.empty()) {
        return no_value;
    }
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

LineFit fit_line(std::span<const FitPoint> points) {
    const auto line = fit<2>(points);
    if (!line.found) {
        return {no_value, no_value, no_value, points.size()};
    }
    const double slope = line.c[1] / line.scale;
    return {line.c[0] - slope * line.middle, slope, line.residual, points.size()};
}

LineFit fit_line_robustly(std::span<const FitPoint> points, double least_deviation) {
    const double slope = median_slope(points);
    if (std::isnan(slope)) {
        return fit_line(points);
    }
    std::vector<double> offsets(points.size());
    std::transform(points.begin(), points.end(), offsets.begin(),
                   [&](const FitPoint& point) { return point.value - slope * point.at; });
    const double centre = median(offsets);
    std::vector<double> distances(offsets.size());
    std::transform(offsets.begin(), offsets.end(), distances.begin(), [&](double o) { return std::abs(o - centre); });
    const double deviation = std::max(1.4826 * median(distances), least_deviation);
    std::vector<FitPoint> kept;
    for (std::size_t k = 0; k < points.size(); ++k) {
        if (distances[k] <= 3 * deviation) {
            kept.push_back(points[k]);
        }
    }
    return fit_line(kept);
}

double fit_curvature(std::span<const FitPoint> points) {
    const auto parabola = fit<3>(points);
    return parabola.found ? 2 * parabola.c[2] / (parabola.scale * parabola.scale) : no_value;
}

} // namespace nappe
