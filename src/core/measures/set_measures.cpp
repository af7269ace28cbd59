#include "core/measures/set_measures.hpp"

#include "core/no_value.hpp"
#include "core/stress.hpp"

#include <cmath>
#include <numbers>

namespace nappe {

namespace {

double ratio(double a, double b) {
    return b > 0 ? a / b : no_value;
}

/// Of the axis of the larger principal value to x, in (-pi/2, pi/2]; NaN if both are equal [rad].
double principal_angle(const Eigen::Matrix2d& t) {
    const double difference = t(0, 0) - t(1, 1);
    const double shear = t(0, 1) + t(1, 0);
    if (difference == 0 && shear == 0) {
        return no_value;
    }
    const double angle = 0.5 * std::atan2(shear, difference);
    return angle > -0.5 * std::numbers::pi ? angle : 0.5 * std::numbers::pi; // atan2(-0, -1) is -pi
}

} // namespace

const std::vector<std::string>& SetFigures::names() {
    static const std::vector<std::string> names{"p",
                                                "q",
                                                "angle",
                                                "fabric_1",
                                                "fabric_2",
                                                "fabric_angle",
                                                "anisotropy",
                                                "anisotropy_normalised",
                                                "coordination",
                                                "coordination_backbone",
                                                "rattlers",
                                                "solid_fraction",
                                                "lambda_x",
                                                "lambda_y",
                                                "overlap_mean",
                                                "overlap_max",
                                                "grains"};
    return names;
}

std::array<double, 17> SetFigures::values() const {
    return {p,
            q,
            angle,
            fabric_1,
            fabric_2,
            fabric_angle,
            anisotropy,
            anisotropy_normalised,
            coordination,
            coordination_backbone,
            rattlers,
            solid_fraction,
            lambda_x,
            lambda_y,
            overlap_mean,
            overlap_max,
            grains};
}

template <int D>
SetSums<D>::SetSums() : sums_(n_sums) {
    extremes_.fill(-std::numeric_limits<double>::infinity());
    extremes_.back() = 0;
}

template <int D>
void SetSums<D>::add(const MeasuredGrain<D>& grain) {
    static_assert(D == 2, "the area below is a disk's");
    const auto& row = grain.row->grain;
    const auto& load = *grain.load;
    for (int i = 0; i < D; ++i) {
        for (int j = 0; j < D; ++j) {
            const auto at = static_cast<std::size_t>(i * D + j);
            sums_[at].add(load.moment(i, j));
            sums_[fabric_at + at].add(load.fabric(i, j));
        }
        double* extreme = &extremes_[2 * static_cast<std::size_t>(i)];
        extreme[0] = row.x[i] > extreme[0] ? row.x[i] : extreme[0];
        extreme[1] = -row.x[i] > extreme[1] ? -row.x[i] : extreme[1];
    }
    extremes_.back() = load.largest_overlap > extremes_.back() ? load.largest_overlap : extremes_.back();
    const double area = std::numbers::pi * row.radius * row.radius;
    sums_[share_at].add(load.share);
    sums_[overlap_at].add(load.overlap);
    sums_[area_at].add(area);
    sums_[room_at].add(area / grain.solid_fraction);
    ++counts_[0];
    counts_[1] += load.contacts;
    counts_[2] += grain.backbone_contacts;
    counts_[3] += grain.rattler ? 1 : 0;
}

template <int D>
Vec<D> SetSums<D>::extent() const {
    Vec<D> extent = Vec<D>::Zero();
    for (int d = 0; d < D && n_grains() > 0; ++d) {
        extent[d] = extremes_[2 * static_cast<std::size_t>(d)] + extremes_[2 * static_cast<std::size_t>(d) + 1];
    }
    return extent;
}

template <int D>
Eigen::Matrix2d SetSums<D>::tensor(std::size_t at) const {
    Eigen::Matrix2d t;
    t << sum(at), sum(at + 1), sum(at + 2), sum(at + 3);
    return t;
}

template <int D>
SetFigures SetSums<D>::figures(const SetReference<D>& at_start, double h) const {
    const double volume = at_start.solid_fraction > 0 ? area() / at_start.solid_fraction : no_value;
    const Eigen::Matrix2d sigma = tensor(0) / (h * volume);
    const Eigen::Matrix2d fabric = tensor(fabric_at);
    const auto stress = principal_stress(sigma);
    const auto texture = principal_stress(fabric); // mean and half difference of the eigenvalues
    const auto grains = static_cast<double>(n_grains());
    const auto backbone = static_cast<double>(n_grains() - counts_[3]);
    SetFigures f{};
    f.p = stress.p;
    f.q = stress.q;
    f.angle = principal_angle(sigma);
    f.fabric_1 = (texture.p + texture.q) / volume;
    f.fabric_2 = (texture.p - texture.q) / volume;
    f.fabric_angle = principal_angle(fabric);
    f.anisotropy = texture.q / volume;
    f.anisotropy_normalised = ratio(texture.q, sum(share_at));
    f.coordination = ratio(static_cast<double>(counts_[1]), grains);
    f.coordination_backbone = ratio(static_cast<double>(counts_[2]), backbone);
    f.rattlers = static_cast<double>(counts_[3]);
    f.solid_fraction = ratio(area(), sum(room_at));
    const Vec<D> now = extent();
    f.lambda_x = ratio(now[0], at_start.extent[0]);
    f.lambda_y = ratio(now[1], at_start.extent[1]);
    f.overlap_mean = ratio(sum(overlap_at), sum(share_at));
    f.overlap_max = n_grains() > 0 ? extremes_.back() : no_value;
    f.grains = grains;
    return f;
}

template class SetSums<2>;

} // namespace nappe
