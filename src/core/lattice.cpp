#include "core/lattice.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nappe {

namespace {

struct Box {
    Vec<2> min = Vec<2>::Zero(), max = Vec<2>::Zero();
};

Box box_of(const std::vector<Vec<2>>& profile) {
    Box box{profile.front(), profile.front()};
    for (const auto& p : profile) {
        box.min = box.min.cwiseMin(p);
        box.max = box.max.cwiseMax(p);
    }
    return box;
}

/// Four corners, each of the box's, neighbours on one side of it.
bool is_box(const std::vector<Vec<2>>& profile) {
    if (profile.size() != 4) {
        return false;
    }
    const Box box = box_of(profile);
    for (std::size_t k = 0; k < 4; ++k) {
        const Vec<2>&p = profile[k], &next = profile[(k + 1) % 4];
        for (int d = 0; d < 2; ++d) {
            if (p[d] != box.min[d] && p[d] != box.max[d]) {
                return false;
            }
        }
        if ((p[0] == next[0]) == (p[1] == next[1])) {
            return false;
        }
    }
    return true;
}

/// Whole lengths of `each` in `length`.
std::int64_t whole(double length, double each) {
    return static_cast<std::int64_t>(std::floor(length / each + 1e-9));
}

/// Rows from the foot up; every other one has one grain less if they are staggered.
struct Layout {
    std::int64_t rows = 0, columns = 0;
    double rise = 0; ///< from row to row [m]
    bool staggered = false;

    std::int64_t in_row(std::int64_t j) const { return staggered && j % 2 == 1 ? columns - 1 : columns; }
};

Layout layout_of(const Sample<2>& sample) {
    const Box box = box_of(sample.profile);
    const double r = sample.radii.max, d = 2 * r;
    Layout layout;
    layout.staggered = sample.arrangement == Sample<2>::Arrangement::staggered;
    layout.rise = layout.staggered ? std::sqrt(3.0) * r : d;
    layout.columns = whole(box.max[0] - box.min[0], d);
    const double height = box.max[1] - box.min[1];
    layout.rows = whole(height, d) < 1 ? 0 : 1 + whole(height - d, layout.rise);
    return layout;
}

} // namespace

std::int64_t lattice_size(const Sample<2>& sample) {
    const Layout layout = layout_of(sample);
    return layout.rows * layout.columns - (layout.staggered ? layout.rows / 2 : 0);
}

LatticeFault lattice_fault(const Sample<2>& sample) {
    if (sample.radii.min != sample.radii.max) {
        return {"radius",
                fmt::format("must be one for a lattice, found {} to {} [m]; write {{ law = \"constant\", value = … }}, "
                            "or arrangement = \"deposit\"",
                            sample.radii.min, sample.radii.max)};
    }
    if (!is_box(sample.profile)) {
        return {"profile",
                "must be a rectangle along the axes for a lattice, found another polygon; give its four corners, or "
                "arrangement = \"deposit\""};
    }
    return {};
}

std::vector<GrainRow<2>> lattice(const Sample<2>& sample, double density) {
    const Box box = box_of(sample.profile);
    const double r = sample.radii.max;
    const Layout layout = layout_of(sample);
    const double middle = 0.5 * (box.min[0] + box.max[0]);
    std::vector<GrainRow<2>> grains;
    for (std::int64_t j = 0; j < layout.rows; ++j) {
        const auto n = layout.in_row(j);
        for (std::int64_t i = 0; i < n; ++i) {
            GrainRow<2> row;
            row.id = static_cast<GlobalId>(grains.size());
            row.x = {middle + (static_cast<double>(2 * i + 1 - n)) * r,
                     box.min[1] + r + static_cast<double>(j) * layout.rise};
            row.radius = r;
            row.mass = density * std::numbers::pi * r * r;
            row.material = sample.material;
            const auto& tops = sample.layer_tops;
            row.layer =
                static_cast<std::int32_t>(std::upper_bound(tops.begin(), tops.end(), row.x[1]) - tops.begin()) + 1;
            grains.push_back(row);
        }
    }
    return grains;
}

} // namespace nappe
