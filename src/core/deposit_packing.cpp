#include "core/deposit_packing.hpp"

#include <algorithm>
#include <cmath>

namespace nappe {

namespace {

/// Round-off of a position is about 1e-16 of its distance from the origin; this share of a radius lets two disks that
/// touch count as free of overlap up to 100 km from the origin, and stays ten times below the overlap that is promised.
constexpr double clearance_tolerance = 1e-10;

/// A vertical wall, or a centre right above a support, up to the round-off of a rotated frame.
constexpr double direction_tolerance = 1e-9;

/// Two supports whose normals are closer than this (sine of the angle) hold a disk like one alone.
constexpr double least_angle = 1e-6;

} // namespace

Packing::Packing(std::vector<Vec<2>> profile, double r_min, double r_max)
    : profile_(std::move(profile)), r_max_(r_max) {
    if (signed_area(profile_) < 0) {
        std::reverse(profile_.begin(), profile_.end());
    }
    const std::size_t n = profile_.size();
    for (std::size_t i = 0; i < n; ++i) {
        const Vec<2> along = profile_[(i + 1) % n] - profile_[i];
        const double length = std::sqrt(along.dot(along));
        const Vec<2> direction = along / length;
        const Vec<2> normal(-direction[1], direction[0]);
        edges_.push_back({profile_[i], direction, normal, length, normal[1] < -direction_tolerance});
    }
    make_grid();
    enter_edges_into_grid();
    disks_.reserve(static_cast<std::size_t>(signed_area(profile_) / (3 * r_min * r_max)) + n);
    for (std::size_t i = 0; i < n; ++i) {
        const Edge& before = edges_[(i + n - 1) % n];
        const bool points_inwards = cross(before.direction, edges_[i].direction) < -direction_tolerance;
        if (points_inwards && !(before.hangs_over && edges_[i].hangs_over)) {
            add_disk(profile_[i], 0);
        }
    }
}

Trial Packing::try_site(const Site& site, double radius) const {
    const bool on_disk = site.a >= 0 || site.b >= 0;
    const Touch touch = site.a >= 0 && site.b >= 0 ? touch_disks(site, radius)
                        : on_disk                  ? touch_disk_and_edge(site, radius)
                                                   : touch_edges(site, radius);
    if (touch.fit != Fit::fits) {
        return {touch.fit, {}};
    }
    if (const Fit fit = stability(touch); fit != Fit::fits) {
        return {fit, {}};
    }
    if (const Fit fit = clearance(touch, radius); fit != Fit::fits) {
        return {fit, {}};
    }
    // Who touches a disk inside the profile, and overlaps no edge, is inside too.
    const auto is_grain = [&](SupportId support) { return support >= 0 && disks_[support].radius > 0; };
    if (!is_grain(site.a) && !is_grain(site.b) && !is_inside(profile_, touch.centre)) {
        return {Fit::too_large, {}};
    }
    return {Fit::fits, touch.centre};
}

Packing::Touch Packing::touch_disks(const Site& site, double radius) const {
    const Disk& a = disks_[site.a];
    const Disk& b = disks_[site.b];
    const Vec<2> between = b.centre - a.centre;
    const double distance = std::sqrt(between.dot(between));
    const double reach = a.radius + radius;
    const double along = (distance + (a.radius - b.radius) * (a.radius + b.radius + 2 * radius) / distance) / 2;
    const double across2 = reach * reach - along * along;
    if (!(across2 >= 0)) {
        return {{}, {}, {}, Fit::too_small};
    }
    const Vec<2> direction = between / distance;
    // Of the two places, the one above the line of centres: the other can not be stable.
    Vec<2> normal(-direction[1], direction[0]);
    if (normal[1] < 0) {
        normal = -normal;
    }
    const Vec<2> from_a = along * direction + std::sqrt(across2) * normal;
    const Vec<2> from_b = from_a - between;
    return {a.centre + from_a, from_a / reach, from_b / (b.radius + radius), Fit::fits};
}

Packing::Touch Packing::touch_disk_and_edge(const Site& site, double radius) const {
    const bool ahead = site.a >= 0;
    const Disk& disk = disks_[ahead ? site.a : site.b];
    const Edge& edge = edges_[~(ahead ? site.b : site.a)];
    const double height = (disk.centre - edge.start).dot(edge.normal);
    const double along2 = (disk.radius + height) * (disk.radius + 2 * radius - height);
    if (!(along2 >= 0)) {
        return {{}, {}, {}, Fit::too_small};
    }
    const double along = ahead ? std::sqrt(along2) : -std::sqrt(along2);
    const Vec<2> from_disk = (radius - height) * edge.normal + along * edge.direction;
    const Vec<2> centre = disk.centre + from_disk;
    return {centre, from_disk / (disk.radius + radius), edge.normal, beside_edge(edge, centre, along)};
}

Packing::Touch Packing::touch_edges(const Site& site, double radius) const {
    const Edge& a = edges_[~site.a];
    const Edge& b = edges_[~site.b];
    const double sine = cross(a.direction, b.direction);
    const double cosine = a.direction.dot(b.direction);
    if (!(sine > least_angle || sine < -least_angle)) {
        return {{}, {}, {}, Fit::too_small};
    }
    const Vec<2> meeting = a.start + a.direction * (cross(b.start - a.start, b.direction) / sine);
    const Vec<2> motion = (a.normal + b.normal) / (1 + cosine);
    const Vec<2> centre = meeting + radius * motion;
    const Fit beside_a = beside_edge(a, centre, motion.dot(a.direction));
    const Fit beside_b = beside_edge(b, centre, motion.dot(b.direction));
    return {centre, a.normal, b.normal, beside_a != Fit::fits ? beside_a : beside_b};
}

/// Whether the foot of the centre lies on the edge, and not on the line beyond its ends. `motion` has the sign of the
/// foot's motion as the radius grows.
Fit Packing::beside_edge(const Edge& edge, const Vec<2>& centre, double motion) const {
    const double foot = (centre - edge.start).dot(edge.direction);
    const double tolerance = clearance_tolerance * r_max_;
    if (foot < -tolerance) {
        return motion > 0 ? Fit::too_small : Fit::too_large;
    }
    if (foot > edge.length + tolerance) {
        return motion > 0 ? Fit::too_large : Fit::too_small;
    }
    return Fit::fits;
}

Fit Packing::stability(const Touch& touch) {
    const double sine = cross(touch.n_a, touch.n_b);
    if (!(sine > least_angle || sine < -least_angle)) {
        return Fit::too_small;
    }
    // Up = share_a n_a + share_b n_b.
    const double share_a = -touch.n_b[0] / sine;
    const double share_b = touch.n_a[0] / sine;
    return share_a < -direction_tolerance || share_b < -direction_tolerance ? Fit::too_large : Fit::fits;
}

Fit Packing::clearance(const Touch& touch, double radius) const {
    const Vec<2>& centre = touch.centre;
    if (!(centre[0] > low_[0] && centre[0] < high_[0] && centre[1] > low_[1] && centre[1] < high_[1])) {
        return Fit::too_large;
    }
    const auto blocked_by = [&](const Vec<2>& to_obstacle, double distance2) {
        const double towards = (touch.n_a + touch.n_b).dot(to_obstacle);
        const bool on_arc_between_supports = towards < -(1 + touch.n_a.dot(touch.n_b)) * std::sqrt(distance2);
        return on_arc_between_supports ? Fit::too_small : Fit::too_large;
    };
    const int i = column(centre[0]);
    const int j = row(centre[1]);
    const double least = radius * (1 - clearance_tolerance);
    for (auto k = first_edge_[cell(i, j)]; k < first_edge_[cell(i, j) + 1]; ++k) {
        const Edge& edge = edges_[edge_of_cell_[k]];
        const double foot = (centre - edge.start).dot(edge.direction);
        const double nearest = foot < 0 ? 0 : foot > edge.length ? edge.length : foot;
        const Vec<2> to_edge = edge.start + nearest * edge.direction - centre;
        const double distance2 = to_edge.dot(to_edge);
        if (distance2 < least * least) {
            return blocked_by(to_edge, distance2);
        }
    }
    for (int jj = std::max(j - 1, 0); jj <= std::min(j + 1, n_rows_ - 1); ++jj) {
        for (int ii = std::max(i - 1, 0); ii <= std::min(i + 1, n_columns_ - 1); ++ii) {
            for (auto k = newest_disk_[cell(ii, jj)]; k >= 0; k = disks_[k].next) {
                const Vec<2> to_disk = disks_[k].centre - centre;
                const double distance2 = to_disk.dot(to_disk);
                const double apart = (disks_[k].radius + radius) * (1 - clearance_tolerance);
                if (distance2 < apart * apart) {
                    return blocked_by(to_disk, distance2);
                }
            }
        }
    }
    return Fit::fits;
}

std::vector<Site> Packing::sites_of_profile() const {
    std::vector<Site> sites;
    const auto n = static_cast<SupportId>(edges_.size());
    const auto end = [](const Edge& edge) -> Vec<2> { return edge.start + edge.length * edge.direction; };
    for (SupportId i = 0; i < n; ++i) {
        for (SupportId j = i + 1; j < n; ++j) {
            if (segment_distance(edges_[i].start, end(edges_[i]), edges_[j].start, end(edges_[j])) <= 2 * r_max_) {
                sites.push_back({~i, ~j});
            }
        }
    }
    for (SupportId corner = 0; corner < static_cast<SupportId>(disks_.size()); ++corner) {
        const auto more = sites_of_disk(corner);
        sites.insert(sites.end(), more.begin(), more.end());
    }
    return sites;
}

SupportId Packing::add_disk(const Vec<2>& centre, double radius) {
    auto& newest = newest_disk_[cell(column(centre[0]), row(centre[1]))];
    const auto disk = static_cast<SupportId>(disks_.size());
    disks_.push_back({centre, radius, newest});
    newest = disk;
    return disk;
}

std::vector<Site> Packing::sites_of_disk(SupportId disk) const {
    const Vec<2> centre = disks_[disk].centre;
    const double reach = disks_[disk].radius + 2 * r_max_;
    std::vector<Site> sites;
    const std::size_t home = cell(column(centre[0]), row(centre[1]));
    for (auto k = first_edge_[home]; k < first_edge_[home + 1]; ++k) {
        const SupportId edge = ~edge_of_cell_[k];
        const bool near = (centre - edges_[~edge].start).dot(edges_[~edge].normal) <= reach;
        if (near && !edges_[~edge].hangs_over) {
            sites.push_back({disk, edge});
            sites.push_back({edge, disk});
        }
    }
    const int last_column = column(centre[0] + reach + r_max_);
    const int last_row = row(centre[1] + reach + r_max_);
    for (int j = row(centre[1] - reach - r_max_); j <= last_row; ++j) {
        for (int i = column(centre[0] - reach - r_max_); i <= last_column; ++i) {
            for (auto k = newest_disk_[cell(i, j)]; k >= 0; k = disks_[k].next) {
                const Vec<2> between = disks_[k].centre - centre;
                const double within = reach + disks_[k].radius;
                if (k < disk && between.dot(between) <= within * within) {
                    sites.push_back({k, disk});
                }
            }
        }
    }
    return sites;
}

} // namespace nappe
