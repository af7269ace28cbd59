#include "core/walls.hpp"

#include "core/polygon.hpp"

#include <cmath>

namespace nappe {

template <int D>
Walls<D>::Walls(const std::vector<Wall<D>>& walls) {
    for (std::size_t w = 0; w < walls.size(); ++w) {
        names_.push_back(walls[w].name);
        materials_.push_back(walls[w].material);
        points_.push_back(walls[w].points);
        const auto& points = walls[w].points;
        const bool closed = points.front() == points.back() && points.size() > 2;
        const std::size_t n_segments = points.size() - 1;
        std::vector<Feature> segments;
        for (std::size_t k = 0; k < n_segments; ++k) {
            Feature f;
            f.wall = static_cast<int>(w);
            f.p = points[k];
            const Vec<D> along = points[k + 1] - points[k];
            f.length = along.norm();
            f.tangent = along / f.length;
            segments.push_back(f);
        }
        features_.insert(features_.end(), segments.begin(), segments.end());
        for (std::size_t k = 0; k < points.size() - (closed ? 1 : 0); ++k) {
            Feature f;
            f.wall = static_cast<int>(w);
            f.is_point = true;
            f.p = points[k];
            f.has_before = k > 0 || closed;
            f.has_after = k < n_segments;
            if (f.has_before) {
                const Feature& before = segments[k > 0 ? k - 1 : n_segments - 1];
                f.before = before.tangent;
                f.before_p = before.p;
                f.before_length = before.length;
            }
            if (f.has_after) {
                f.after = segments[k].tangent;
            }
            features_.push_back(f);
        }
    }
    const auto n = walls.size();
    offset.assign(n, Vec<D>::Zero());
    offset_mid = offset_ref = v = v_old = offset;
    margin.assign(n, 0.0);
}

template <int D>
std::vector<Vec<D>> Walls<D>::points(int wall) const {
    auto moved = points_[static_cast<std::size_t>(wall)];
    for (auto& p : moved) {
        p += offset[static_cast<std::size_t>(wall)];
    }
    return moved;
}

template <int D>
int Walls<D>::side_of(int feature, const Vec<D>& x_ref) const {
    const Feature& f = features_[static_cast<std::size_t>(feature)];
    if (f.is_point) {
        return 2 * feature;
    }
    const Vec<D> d = x_ref - (f.p + offset_ref[static_cast<std::size_t>(f.wall)]);
    return 2 * feature + (cross(f.tangent, d) >= 0 ? 0 : 1);
}

template <int D>
double Walls<D>::distance_ref(int feature, const Vec<D>& x) const {
    const Feature& f = features_[static_cast<std::size_t>(feature)];
    const Vec<D> d = x - (f.p + offset_ref[static_cast<std::size_t>(f.wall)]);
    if (f.is_point) {
        return d.norm();
    }
    const double along = d.dot(f.tangent);
    const double clamped = along < 0 ? 0 : (along > f.length ? f.length : along);
    return (d - clamped * f.tangent).norm();
}

template <int D>
WallContact<D> Walls<D>::contact(int sided, const Vec<D>& x, double radius) const {
    const Feature& f = feature(sided);
    const Vec<D>& moved = offset_mid[static_cast<std::size_t>(f.wall)];
    const Vec<D> d = x - (f.p + moved);
    WallContact<D> c;
    if (f.is_point) {
        const Vec<D> d_before = x - (f.before_p + moved);
        c.applies = (!f.has_before || d_before.dot(f.before) > f.before_length) && (!f.has_after || d.dot(f.after) < 0);
        c.distance = d.norm();
        c.n = d / c.distance;
        return c;
    }
    const double along = d.dot(f.tangent);
    c.applies = along >= 0 && along <= f.length;
    const double left = cross(f.tangent, d);
    const double side = sided % 2 == 0 ? 1.0 : -1.0;
    const double sign = left >= 0 ? 1.0 : -1.0;
    c.distance = left * sign;
    c.n = Vec<D>(-f.tangent[1], f.tangent[0]) * sign;
    // On the other side but close to the line: went through. Far from it: came round the end of the wall.
    c.through = c.applies && sign != side && c.distance < 0.5 * radius;
    return c;
}

template <int D>
bool Walls<D>::crossed(int sided, const Vec<D>& x, const Vec<D>& move) const {
    const Feature& f = feature(sided);
    if (f.is_point) {
        return false;
    }
    const Vec<D> end = x - (f.p + offset_mid[static_cast<std::size_t>(f.wall)]);
    const double side = sided % 2 == 0 ? 1.0 : -1.0;
    const double height = side * cross(f.tangent, end);
    const double height_before = height - side * cross(f.tangent, move);
    if (!(height < 0 && height_before >= 0)) {
        return false;
    }
    const double along = (end - move * (height / (height - height_before))).dot(f.tangent);
    const double slack = 1e-9 * f.length; // well above round-off, so that a joint is no gap
    return along >= -slack && along <= f.length + slack;
}

template <int D>
Vec<D> driven_velocity(const Wall<D>& wall, int stage, bool preparing, double time_before, double time) {
    if (!wall.motion) {
        return Vec<D>::Zero();
    }
    const auto& motion = *wall.motion;
    // Half a step of tolerance on times: a motion that starts at the end of a step starts with the next one.
    const double middle = 0.5 * (time_before + time);
    if (motion.stop && middle > *motion.stop) {
        return Vec<D>::Zero();
    }
    const bool started = motion.stage >= 0 ? stage >= motion.stage : (!preparing && middle > motion.start);
    return started ? motion.velocity : Vec<D>::Zero();
}

template class Walls<2>;
template Vec<2> driven_velocity(const Wall<2>&, int, bool, double, double);

} // namespace nappe
