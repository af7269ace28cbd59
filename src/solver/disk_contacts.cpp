#include "solver/disk_contacts.hpp"

#include "core/contact_geometry.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <cmath>

namespace nappe {

namespace {

double normal_speed(const Vec<2>& n, const BodyVelocity<2>& a, const BodyVelocity<2>& b) {
    return n[0] * (a.v[0] - b.v[0]) + n[1] * (a.v[1] - b.v[1]);
}

/// Detection positions go from x_mid - h v to x_mid from one step to the next.
bool went_through(const State<2>& state, const Walls<2>& walls, const ContactGeometry<2>& g, LocalId a, LocalId b,
                  double h) {
    if (g.through || b < state.n_held()) {
        return g.through;
    }
    const auto& v_a = state.u_old[a].v;
    const auto& v_b = state.u_old[b].v;
    return walls.crossed(b - state.n_held(), state.x_mid[a], h * Vec<2>(v_a[0] - v_b[0], v_a[1] - v_b[1]));
}

/// Whether a or b is in the batch already; walls may be, they are never written.
[[maybe_unused]] bool shares_grain(const DiskBatch& batch, LocalId a, LocalId b, LocalId n_grains) {
    for (int l = 0; l < n_lanes; ++l) {
        for (const LocalId other : {batch.a[l], batch.b[l]}) {
            if (other < n_grains && (other == a || other == b)) {
                return true;
            }
        }
    }
    return false;
}

} // namespace

PairLaws::PairLaws(const Scene<2>& scene) : n_(static_cast<int>(scene.materials.size())) {
    friction_.assign(static_cast<std::size_t>(n_ * n_), 0.0);
    restitution_ = friction_;
    for (std::size_t k = 0; k < scene.laws.size(); ++k) {
        const auto& law = scene.laws[k];
        for (const int at : {law.material_a * n_ + law.material_b, law.material_b * n_ + law.material_a}) {
            friction_[static_cast<std::size_t>(at)] = law.friction;
            restitution_[static_cast<std::size_t>(at)] = law.restitution;
        }
        any_restitution = any_restitution || law.restitution > 0;
        uniform = uniform && law.friction == scene.laws.front().friction;
    }
    uniform_friction = scene.laws.empty() ? 0.0 : scene.laws.front().friction;
}

PackFaults DiskContacts::pack(const State<2>& state, const CandidateSet<2>& candidates, const Walls<2>& walls, double h,
                              bool activate_all) {
    PackFaults faults;
    batches_.clear();
    friction_.clear();
    source_.clear();
    ranges_.clear();
    left_out_.clear();
    n_active_ = 0;

    DiskBatch null{};
    std::fill(std::begin(null.nx), std::end(null.nx), 1.0);
    std::fill(std::begin(null.a), std::end(null.a), state.null_body());
    std::fill(std::begin(null.b), std::end(null.b), state.null_body());

    for (const auto& tile : candidates.tiles) {
        Range range;
        range.begin = static_cast<std::int64_t>(batches_.size());
        for (auto k = tile.classes_begin; k < tile.classes_end; ++k) {
            int lane = n_lanes; // a class starts a batch of its own: batches share no grain
            for (auto c = candidates.class_begin[k]; c < candidates.class_end(tile, k); ++c) {
                const LocalId a = candidates.a[c], b = candidates.b[c];
                const auto g = contact_geometry(state, walls, a, b);
                if (went_through(state, walls, g, a, b, h) && state.id[a] < faults.through_wall) {
                    faults.through_wall = state.id[a];
                    faults.wall = walls.feature(b - state.n_held()).wall;
                }
                if (!g.applies) {
                    continue;
                }
                const double v_free = normal_speed(g.n, state.u[a], state.u[b]);
                double bias = g.gap > 0 ? g.gap / h : 0.0;
                if (laws_.any_restitution && laws_.restitution(state.material[a], state.material[b]) > 0) {
                    // Newton's law needs the approach that free flight brings; a gap bias would take it away a step
                    // early.
                    if (g.gap > 0 && g.gap + h * v_free > 0) {
                        continue;
                    }
                    const double v_old = normal_speed(g.n, state.u_old[a], state.u_old[b]);
                    bias = laws_.restitution(state.material[a], state.material[b]) * (v_old < 0 ? v_old : 0.0);
                } else if (!activate_all && g.gap > 0) {
                    const double v_old = normal_speed(g.n, state.u_old[a], state.u_old[b]);
                    const double slower = v_old < v_free ? v_old : v_free;
                    const double size = state.radius[a] + (b < state.n_held() ? state.radius[b] : state.radius[a]);
                    if (g.gap > 0.01 * size + (slower < 0 ? -2 * h * slower : 0.0)) {
                        left_out_.push_back(c);
                        continue;
                    }
                }
                if (lane == n_lanes) {
                    batches_.push_back(null);
                    source_.insert(source_.end(), n_lanes, -1);
                    if (!laws_.uniform) {
                        friction_.push_back({});
                    }
                    lane = 0;
                }
                DiskBatch& batch = batches_.back();
                NAPPE_ASSERT(!shares_grain(batch, a, b, state.n_held()),
                             "a batch holds grain " + std::to_string(state.id[a]) + " or its partner twice");
                batch.nx[lane] = g.n[0];
                batch.ny[lane] = g.n[1];
                batch.bias[lane] = bias;
                batch.m_eff[lane] = 1.0 / (state.u[a].inv_m + state.u[b].inv_m);
                batch.r_n[lane] = candidates.r[c].n;
                batch.r_t[lane] = candidates.r[c].t[0];
                batch.a[lane] = a;
                batch.b[lane] = b;
                if (!laws_.uniform) {
                    friction_.back().mu[lane] = laws_.friction(state.material[a], state.material[b]);
                }
                source_[source_.size() - static_cast<std::size_t>(n_lanes - lane)] = c;
                ++lane;
                ++range.active;
            }
        }
        range.end = static_cast<std::int64_t>(batches_.size());
        n_active_ += range.active;
        ranges_.push_back(range);
    }
    return faults;
}

bool DiskContacts::missed_any(const State<2>& state, const CandidateSet<2>& candidates, const Walls<2>& walls,
                              double h) const {
    return std::any_of(left_out_.begin(), left_out_.end(), [&](std::int32_t c) {
        const LocalId a = candidates.a[c], b = candidates.b[c];
        const auto g = contact_geometry(state, walls, a, b);
        return g.gap + h * normal_speed(g.n, state.u[a], state.u[b]) < 0;
    });
}

RawResidual DiskContacts::residual(std::size_t tile, const std::vector<BodyVelocity<2>>& u) const {
    RawResidual sum;
    for (auto k = ranges_[tile].begin; k < ranges_[tile].end; ++k) {
        const DiskBatch& batch = batches_[static_cast<std::size_t>(k)];
        for (int l = 0; l < n_lanes; ++l) {
            if (source_[static_cast<std::size_t>(k * n_lanes + l)] < 0) {
                continue;
            }
            const auto& a = u[batch.a[l]];
            const auto& b = u[batch.b[l]];
            const double dvx = a.v[0] - b.v[0], dvy = a.v[1] - b.v[1];
            const double v_n = batch.nx[l] * dvx + batch.ny[l] * dvy;
            const double v_t = (batch.nx[l] * dvy - batch.ny[l] * dvx) - (a.s[0] + b.s[0]);
            const double w_n = 1.0 / batch.m_eff[l], w_t = 3.0 * w_n;
            const double mu = laws_.uniform ? laws_.uniform_friction : friction_[static_cast<std::size_t>(k)].mu[l];
            const double wanted_n = batch.r_n[l] - (v_n + batch.bias[l]) * batch.m_eff[l];
            const double new_n = wanted_n > 0 ? wanted_n : 0.0;
            const double limit = mu * new_n;
            const double wanted_t = batch.r_t[l] - v_t / w_t;
            const double above = wanted_t > limit ? limit : wanted_t;
            const double new_t = above < -limit ? -limit : above;
            const double e_n = w_n * (batch.r_n[l] - new_n), e_t = w_t * (batch.r_t[l] - new_t);
            const double squared = e_n * e_n + e_t * e_t;
            sum.largest_squared = squared > sum.largest_squared ? squared : sum.largest_squared;
            sum.sum_squared += squared;
            ++sum.contacts;
        }
    }
    return sum;
}

std::pair<double, std::int64_t> DiskContacts::touching_speed(std::size_t tile,
                                                             const std::vector<BodyVelocity<2>>& u) const {
    double sum = 0;
    std::int64_t n = 0;
    for (auto k = ranges_[tile].begin; k < ranges_[tile].end; ++k) {
        const DiskBatch& batch = batches_[static_cast<std::size_t>(k)];
        for (int l = 0; l < n_lanes; ++l) {
            if (source_[static_cast<std::size_t>(k * n_lanes + l)] >= 0 && batch.bias[l] <= 0) {
                const auto& a = u[batch.a[l]];
                const auto& b = u[batch.b[l]];
                const double dvx = a.v[0] - b.v[0], dvy = a.v[1] - b.v[1];
                const double v_n = batch.nx[l] * dvx + batch.ny[l] * dvy;
                const double v_t = (batch.nx[l] * dvy - batch.ny[l] * dvx) - (a.s[0] + b.s[0]);
                sum += v_n * v_n + v_t * v_t;
                ++n;
            }
        }
    }
    return {sum, n};
}

void DiskContacts::store(CandidateSet<2>& candidates) const {
    std::fill(candidates.r.begin(), candidates.r.end(), Impulse<2>{});
    for (std::size_t slot = 0; slot < source_.size(); ++slot) {
        if (source_[slot] >= 0) {
            const DiskBatch& batch = batches_[slot / n_lanes];
            const auto l = slot % n_lanes;
            candidates.r[source_[slot]] = {batch.r_n[l], {batch.r_t[l]}};
        }
    }
}

} // namespace nappe
