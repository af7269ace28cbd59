#include "core/measures/coarse_grain.hpp"

#include "core/no_value.hpp"

namespace nappe {

CoarseGrain::CoarseGrain(const FieldGrid& grid, const GridRows& rows, double range)
    : grid_(grid), rows_(rows), range_(range), sums_(static_cast<std::size_t>(rows.count * grid.n_x)) {}

void CoarseGrain::add(const FlowGrain& grain) {
    const double slope = -60 / (std::numbers::pi * range_ * range_ * range_ * range_);
    for_each_reached(grid_, rows_, grain.x, range_, [&](std::size_t node, double dx, double dy, double q) {
        auto& s = sums_[node];
        const double w = lucy(q, range_);
        const double steep = grain.mass * slope * (1 - q) * (1 - q);
        const std::array<double, 2> grad{steep * dx, steep * dy}; // m grad W
        s.area += grain.area * w;
        s.rho += grain.mass * w;
        for (std::size_t k = 0; k < 2; ++k) {
            s.grad_rho[k] += grad[k];
            s.p[k] += grain.mass * grain.v[k] * w;
            s.grad_p[2 * k] += grain.v[k] * grad[0];
            s.grad_p[2 * k + 1] += grain.v[k] * grad[1];
        }
    });
}

std::vector<FieldNode> CoarseGrain::fields() const {
    std::vector<FieldNode> nodes(sums_.size(),
                                 {0, {no_value, no_value}, {no_value, no_value, no_value, no_value}, no_value});
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        const auto& s = sums_[k];
        auto& node = nodes[k];
        node.solid_fraction = s.area;
        if (!(s.area >= least_solid_fraction)) {
            continue;
        }
        for (std::size_t a = 0; a < 2; ++a) {
            node.v[a] = s.p[a] / s.rho;
            for (std::size_t b = 0; b < 2; ++b) {
                node.gradient[2 * a + b] = (s.grad_p[2 * a + b] - node.v[a] * s.grad_rho[b]) / s.rho;
            }
        }
        const double stretch = node.gradient[0] - node.gradient[3];
        const double shear = node.gradient[1] + node.gradient[2];
        node.shear_rate = std::sqrt(stretch * stretch + shear * shear);
    }
    return nodes;
}

std::vector<double> coarse_strain(const FieldGrid& grid, const GridRows& rows, double range,
                                  std::span<const FlowGrain> grains) {
    struct Sums {
        double area = 0, rho = 0, strain = 0;
    };
    std::vector<Sums> sums(static_cast<std::size_t>(rows.count * grid.n_x));
    for (const auto& grain : grains) {
        for_each_reached(grid, rows, grain.x, range, [&](std::size_t node, double, double, double q) {
            const double w = lucy(q, range);
            sums[node].area += grain.area * w;
            sums[node].rho += grain.mass * w;
            sums[node].strain += grain.mass * w * grain.strain;
        });
    }
    std::vector<double> mean(sums.size());
    std::transform(sums.begin(), sums.end(), mean.begin(),
                   [](const Sums& s) { return s.area >= least_solid_fraction ? s.strain / s.rho : no_value; });
    return mean;
}

std::optional<double> between_nodes(const FieldGrid& grid, std::span<const double> values,
                                    const std::array<double, 2>& x) {
    const double column = x[0] / grid.spacing - static_cast<double>(grid.first_x);
    const double row = x[1] / grid.spacing - static_cast<double>(grid.first_y);
    const auto i = static_cast<std::int64_t>(std::floor(column));
    const auto j = static_cast<std::int64_t>(std::floor(row));
    double sum = 0, weights = 0;
    for (int corner = 0; corner < 4; ++corner) {
        const auto at_i = i + corner % 2, at_j = j + corner / 2;
        if (at_i < 0 || at_i >= grid.n_x || at_j < 0 || at_j >= grid.n_y) {
            continue;
        }
        const double value = values[grid.node(at_i, at_j)];
        const double weight =
            (1 - std::abs(column - static_cast<double>(at_i))) * (1 - std::abs(row - static_cast<double>(at_j)));
        if (!std::isnan(value)) {
            sum += weight * value;
            weights += weight;
        }
    }
    // A weight of round-off alone says nothing.
    return weights > 1e-9 ? std::optional(sum / weights) : std::nullopt;
}

} // namespace nappe
