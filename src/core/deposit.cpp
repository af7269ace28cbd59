#include "core/deposit.hpp"

#include "core/deposit_packing.hpp"
#include "core/deposit_sites.hpp"
#include "core/error.hpp"
#include "core/random.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/core.h>
#include <numbers>

namespace nappe {

namespace {

/// Axes of the deposit: up, against gravity, and sideways, to the right of it. Along the axes of the plane they are
/// exact, and a sample is turned by quarter turns without a change in any digit.
struct Axes {
    Vec<2> side;
    Vec<2> up;

    explicit Axes(const Vec<2>& gravity) : up(-gravity / std::sqrt(gravity.dot(gravity))) {
        side = Vec<2>(up[1], -up[0]);
    }
    Vec<2> from_plane(const Vec<2>& point) const { return Vec<2>(side.dot(point), up.dot(point)); }
    Vec<2> to_plane(const Vec<2>& point) const { return side * point[0] + up * point[1]; }
};

struct PlacedDisk {
    Vec<2> centre; ///< in the axes of the deposit
    double radius;
};

void check(const Sample<2>& sample, double density, const Vec<2>& gravity) {
    const auto& radii = sample.radii;
    if (!(radii.min > 0) || !(radii.max >= radii.min) || !std::isfinite(radii.max)) {
        throw InputError(
            fmt::format("sample: radii must satisfy 0 < min <= max; found min {}, max {}", radii.min, radii.max));
    }
    if (radii.kind == RadiusLaw::Kind::constant && radii.min != radii.max) {
        throw InputError(
            fmt::format("sample: constant radii have min == max; found min {}, max {}", radii.min, radii.max));
    }
    if (!(density > 0) || !std::isfinite(density)) {
        throw InputError(fmt::format("sample: the density of its material must be positive; found {} kg/m³", density));
    }
    if (!(gravity.dot(gravity) > 0) || !std::isfinite(gravity.dot(gravity))) {
        throw InputError(
            fmt::format("sample: a deposit needs gravity to know what is low; found [{}, {}]; set it, or give the "
                        "grains one by one",
                        gravity[0], gravity[1]));
    }
    if (const auto fault = polygon_fault(sample.profile); !fault.empty()) {
        throw InputError("sample: profile: " + fault);
    }
    if (const double most = most_grains(sample); !(most < most_deposited)) {
        throw InputError(
            fmt::format("sample: a deposit holds at most 1e9 grains; this profile and smallest radius allow "
                        "{:.1e}; use larger grains or a smaller profile",
                        most));
    }
}

std::vector<PlacedDisk> fill(const Sample<2>& sample, const Axes& axes) {
    std::vector<Vec<2>> profile;
    for (const Vec<2>& corner : sample.profile) {
        profile.push_back(axes.from_plane(corner));
    }
    const auto [kind, r_min, r_max] = sample.radii;
    Packing packing(std::move(profile), r_min, r_max);
    SiteHeaps heaps(r_min, r_max, sample.seed);
    for (const Site& site : packing.sites_of_profile()) {
        heaps.offer(packing, site);
    }
    // A place that only the smallest thousandth of all radii fits is not worth waiting for.
    constexpr int patience = 1000;
    std::vector<PlacedDisk> disks;
    int left_out = 0;
    for (std::uint64_t k = 0; left_out < patience && !heaps.empty(); ++k) {
        const double radius = r_min + (r_max - r_min) * random_uniform(sample.seed, RandomStream::deposit_radius, k);
        const auto centre = heaps.lowest(packing, radius);
        if (!centre) {
            ++left_out;
            continue;
        }
        left_out = 0;
        disks.push_back({*centre, radius});
        for (const Site& site : packing.sites_of_disk(packing.add_disk(*centre, radius))) {
            heaps.offer(packing, site);
        }
    }
    return disks;
}

/// By strips of the width of a default tile; within a strip as placed.
void order_by_strips(std::vector<PlacedDisk>& disks, double r_max) {
    const auto strip = [&](const PlacedDisk& disk) { return std::floor(disk.centre[0] / (16 * r_max)); };
    std::stable_sort(disks.begin(), disks.end(),
                     [&](const PlacedDisk& a, const PlacedDisk& b) { return strip(a) < strip(b); });
}

} // namespace

double most_grains(const Sample<2>& sample) {
    return std::abs(signed_area(sample.profile)) / (3 * sample.radii.min * sample.radii.min);
}

std::vector<GrainRow<2>> deposit(const Sample<2>& sample, double density, const Vec<2>& gravity) {
    check(sample, density, gravity);
    const Axes axes(gravity);
    auto disks = fill(sample, axes);
    if (disks.empty()) {
        throw InputError(
            fmt::format("sample: the profile must hold at least one grain; no disk of radius {} to {} m finds "
                        "two supports in it; enlarge the profile or shrink the grains",
                        sample.radii.min, sample.radii.max));
    }
    order_by_strips(disks, sample.radii.max);
    std::vector<GrainRow<2>> rows;
    rows.reserve(disks.size());
    for (const PlacedDisk& disk : disks) {
        const auto& tops = sample.layer_tops;
        const auto layer = std::upper_bound(tops.begin(), tops.end(), disk.centre[1]) - tops.begin();
        const Vec<2> centre = axes.to_plane(disk.centre);
        GrainRow<2> row;
        row.id = static_cast<GlobalId>(rows.size());
        row.x = {centre[0], centre[1]};
        row.radius = disk.radius;
        row.mass = density * std::numbers::pi * disk.radius * disk.radius;
        row.material = sample.material;
        row.layer = static_cast<std::int32_t>(layer) + 1;
        rows.push_back(row);
    }
    return rows;
}

} // namespace nappe
