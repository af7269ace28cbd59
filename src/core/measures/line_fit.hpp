#pragma once
// Least-squares lines and parabolas through a few points, as limits of fault zones and slopes of surfaces are found.
// Local.

#include <cstddef>
#include <span>
#include <vector>

namespace nappe {

struct FitPoint {
    double at = 0;    ///< where: the abscissa [m]
    double value = 0; ///< what is fitted [m]
};

/// value = offset + slope at; NaN where there are too few points.
struct LineFit {
    double offset = 0; ///< at abscissa 0 [m]
    double slope = 0;
    double residual = 0;    ///< root mean square of the distances in `value` [m]
    std::size_t points = 0; ///< that were used
};

/// Needs three points at two places at least.
LineFit fit_line(std::span<const FitPoint> points);

/// Least squares without outliers: points farther than three standard deviations from the line of median slopes
/// (Theil 1950, Sen 1968) are left out, once. The deviation is 1.4826 times the median absolute deviation, as for
/// normal errors, and `least_deviation` [m] at least, so that points on one line are not sorted by round-off.
LineFit fit_line_robustly(std::span<const FitPoint> points, double least_deviation);

/// Second derivative of the least-squares parabola [1/m]; NaN with fewer than four points at three places.
double fit_curvature(std::span<const FitPoint> points);

/// Of a copy, the upper one of the two in the middle; NaN if there is none.
double median(std::vector<double> values);

} // namespace nappe
