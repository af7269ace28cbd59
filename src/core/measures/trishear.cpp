#include "core/measures/trishear.hpp"

#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

#include <cmath>
#include <limits>

namespace nappe {

namespace {

/// A number in (low, high) as one that may be anything, and back: even in its logarithm, since both span decades.
double bounded(double free, double low, double high) {
    return low * std::pow(high / low, 1 / (1 + std::exp(-free)));
}

double freed(double value, double low, double high) {
    const double share = std::log(value / low) / std::log(high / low);
    return std::log(share / (1 - share));
}

/// The residuals of the fit as Eigen's Levenberg–Marquardt wants them: unknowns are the place of the tip, m
/// and s, all freed of their bounds.
class Misfit {
public:
    using Scalar = double;
    using InputType = Eigen::VectorXd;
    using ValueType = Eigen::VectorXd;
    using JacobianType = Eigen::MatrixXd;
    enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

    Misfit(std::span<const VelocityAt> data, const Vec<2>& drive, const TrishearBounds& bounds)
        : data_(data), drive_(drive), bounds_(bounds) {}

    int inputs() const { return 4; }
    int values() const { return static_cast<int>(2 * data_.size()); }

    Trishear model(const InputType& p) const {
        const auto offset = [&](double free) { return bounds_.reach * free / std::sqrt(1 + free * free); };
        return {bounds_.tip + Vec<2>(offset(p[0]), offset(p[1])), bounded(p[2], bounds_.least_m, bounds_.largest_m),
                bounded(p[3], bounds_.least_s, bounds_.largest_s)};
    }

    InputType start(double m, double s) const {
        InputType p(4);
        p << 0, 0, freed(m, bounds_.least_m, bounds_.largest_m), freed(s, bounds_.least_s, bounds_.largest_s);
        return p;
    }

    int operator()(const InputType& p, ValueType& differences) const {
        const auto guess = model(p);
        const double speed = drive_.norm();
        for (std::size_t k = 0; k < data_.size(); ++k) {
            const Vec<2> v = trishear_velocity(guess, drive_, {data_[k].x[0], data_[k].x[1]});
            const auto row = static_cast<Eigen::Index>(2 * k);
            differences[row] = (v[0] - data_[k].v[0]) / speed;
            differences[row + 1] = (v[1] - data_[k].v[1]) / speed;
        }
        return 0;
    }

    /// Root mean square of |v - model| over |V0|.
    double residual(const InputType& p) const {
        ValueType differences(values());
        (*this)(p, differences);
        return std::sqrt(differences.squaredNorm() / static_cast<double>(data_.size()));
    }

private:
    std::span<const VelocityAt> data_;
    Vec<2> drive_;
    TrishearBounds bounds_;
};

/// Unit vectors along the fault and to its upper side.
struct FaultFrame {
    explicit FaultFrame(const Vec<2>& drive)
        : along(drive / drive.norm()), up(along[0] >= 0 ? Vec<2>(-along[1], along[0]) : Vec<2>(along[1], -along[0])) {}

    Vec<2> along, up;
};

double residual_inside(std::span<const VelocityAt> data, const Vec<2>& drive, const Trishear& model) {
    double squares = 0;
    std::size_t n = 0;
    for (const auto& at : data) {
        const Vec<2> x(at.x[0], at.x[1]);
        if (trishear_inside(model, drive, x)) {
            squares += (Vec<2>(at.v[0], at.v[1]) - trishear_velocity(model, drive, x)).squaredNorm();
            ++n;
        }
    }
    return std::sqrt(squares / static_cast<double>(n)) / drive.norm(); // 0/0: none
}

} // namespace

Vec<2> trishear_velocity(const Trishear& model, const Vec<2>& drive, const Vec<2>& x) {
    const double speed = drive.norm();
    const FaultFrame frame(drive);
    const double xi = frame.along.dot(x - model.tip);
    const double eta = frame.up.dot(x - model.tip);
    if (std::abs(eta) >= model.m * xi) {
        return eta >= 0 ? drive : Vec<2>(Vec<2>::Zero());
    }
    const double u = std::abs(eta) / (model.m * xi);
    const double turn = std::pow(u, 1 / model.s);
    const double v_xi = speed / 2 * (std::copysign(turn, eta) + 1);
    const double v_eta = speed / 2 * model.m / (1 + model.s) * (u * turn - 1);
    return v_xi * frame.along + v_eta * frame.up;
}

bool trishear_inside(const Trishear& model, const Vec<2>& drive, const Vec<2>& x) {
    const FaultFrame frame(drive);
    return std::abs(frame.up.dot(x - model.tip)) < model.m * frame.along.dot(x - model.tip);
}

TrishearFit fit_trishear(std::span<const VelocityAt> data, const Vec<2>& drive, const TrishearBounds& bounds) {
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    const TrishearFit nothing{{{unknown, unknown}, unknown, unknown}, unknown, unknown};
    if (data.size() < 8 || !(drive.norm() > 0)) {
        return nothing;
    }
    const Misfit misfit(data, drive, bounds);
    TrishearFit best = nothing;
    for (const double m : {0.2, 0.6, 1.5}) {
        for (const double s : {1.3, 4.0}) {
            Eigen::NumericalDiff<Misfit> with_slopes(misfit);
            Eigen::LevenbergMarquardt<Eigen::NumericalDiff<Misfit>> solver(with_slopes);
            solver.parameters.maxfev = 400;
            Eigen::VectorXd p = misfit.start(m, s);
            solver.minimize(p);
            const double residual = misfit.residual(p);
            if (residual < best.residual || (std::isnan(best.residual) && std::isfinite(residual))) {
                best = {misfit.model(p), residual, unknown};
            }
        }
    }
    best.residual_inside = residual_inside(data, drive, best.model);
    return best;
}

} // namespace nappe
