// What a packed contact problem tells of itself: how far from solved it is, and how fast its contacts move.

#include "solver/disk_contacts.hpp"

namespace nappe {

namespace {

/// Normal and tangential relative velocity of a lane [m/s].
std::pair<double, double> relative_velocity(const DiskBatch& batch, int l, const std::vector<BodyVelocity<2>>& u) {
    const auto& a = u[batch.a[l] / 4];
    const auto& b = u[batch.b[l] / 4];
    const double dvx = a.v[0] - b.v[0], dvy = a.v[1] - b.v[1];
    return {batch.nx[l] * dvx + batch.ny[l] * dvy, (batch.nx[l] * dvy - batch.ny[l] * dvx) - (a.s[0] + b.s[0])};
}

} // namespace

double DiskContacts::squared_residual(const DiskBatch& batch, std::int64_t k, int l,
                                      const std::vector<BodyVelocity<2>>& u) const {
    const auto [v_n, v_t] = relative_velocity(batch, l, u);
    const double w_n = 1.0 / batch.m_eff[l], w_t = 3.0 * w_n;
    const double mu = friction_.empty() ? laws_.uniform_friction : friction_[static_cast<std::size_t>(k)].mu[l];
    const double most = cohesive_ ? cohesion_[static_cast<std::size_t>(k)].most[l] : 0.0;
    const double wanted_n = batch.r_n[l] - (v_n + batch.bias[l]) * batch.m_eff[l];
    const double new_n = wanted_n > -most ? wanted_n : 0.0 - most;
    const double limit = mu * (new_n + most);
    const double r_t = tangential(k, l);
    const double wanted_t = r_t - v_t / w_t;
    const double above = wanted_t > limit ? limit : wanted_t;
    const double new_t = above < -limit ? -limit : above;
    const double e_n = w_n * (batch.r_n[l] - new_n), e_t = w_t * (r_t - new_t);
    return e_n * e_n + e_t * e_t;
}

RawResidual DiskContacts::residual(std::size_t tile, const std::vector<BodyVelocity<2>>& u) const {
    RawResidual sum;
    for_each_residual(tile, u, [&](LocalId, LocalId, double squared) {
        sum.largest_squared = squared > sum.largest_squared ? squared : sum.largest_squared;
        sum.sum_squared += squared;
        ++sum.contacts;
    });
    return sum;
}

std::pair<double, std::int64_t> DiskContacts::touching_speed(std::size_t tile,
                                                             const std::vector<BodyVelocity<2>>& u) const {
    double sum = 0;
    std::int64_t n = 0;
    for_each_lane(tile, [&](const DiskBatch& batch, std::int64_t, int l) {
        if (batch.bias[l] <= 0) {
            const auto [v_n, v_t] = relative_velocity(batch, l, u);
            sum += v_n * v_n + v_t * v_t;
            ++n;
        }
    });
    return {sum, n};
}

} // namespace nappe
