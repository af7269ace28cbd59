#pragma once
// How much momentum an accelerated method takes along; ansgs.hpp says what the letters are.

#include "solver/rounded_sum.hpp"

#include <cmath>
#include <limits>

namespace nappe {

class MomentumSchedule {
public:
    /// @param scale what |z - y|² of the first step may be like [J]
    explicit MomentumSchedule(double scale = 1) : scale_(scale) {}

    double beta() const { return beta_; }   ///< of the step to come
    double scale() const { return scale_; } ///< what its |z - y|² may be like: that of the step before [J]

    /// After a step. @param squared |z - y|² [J] @param along (z - y)·(z - x) [J]
    void next(double squared, double along) {
        constexpr double most_growth = 2;
        if (!(squared > 0)) {
            scale_ *= rounded_off;
            return;
        }
        if (along < 0 || squared > most_growth * smallest_) {
            restart(2 * theta_ < 1 ? 2 * theta_ : 1.0);
        } else {
            const double ahead = 0.5 * theta_ * (std::sqrt(theta_ * theta_ + 4) - theta_);
            beta_ = theta_ * (1 - theta_) / (theta_ * theta_ + ahead);
            theta_ = ahead;
        }
        smallest_ = squared < smallest_ ? squared : smallest_;
        scale_ = squared;
    }

    /// Without momentum from here on.
    void restart(double theta = 1) {
        beta_ = 0;
        theta_ = theta;
        smallest_ = std::numeric_limits<double>::infinity();
    }

private:
    double theta_ = 1;
    double beta_ = 0;
    double scale_;
    double smallest_ = std::numeric_limits<double>::infinity(); ///< |z - y|² since the last restart [J]
};

} // namespace nappe
