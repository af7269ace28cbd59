#include "core/measures/surface.hpp"

#include "core/measures/line_fit.hpp"
#include "core/no_value.hpp"

#include <algorithm>
#include <cmath>

namespace nappe {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Index of the last bin that stands above `level`; -1 if none.
std::ptrdiff_t last_above(const Surface& surface, double level) {
    auto k = static_cast<std::ptrdiff_t>(surface.height.size()) - 1;
    while (k >= 0 && !(surface.height[static_cast<std::size_t>(k)] > level)) {
        --k;
    }
    return k;
}

/// The greatest median of three neighbouring bins, of whatever bins there are if fewer.
double highest(const Surface& surface) {
    const auto& h = surface.height;
    if (h.size() < 3) {
        return h.empty() ? -infinite : *std::min_element(h.begin(), h.end());
    }
    double best = -infinite;
    for (std::size_t k = 1; k + 1 < h.size(); ++k) {
        best = std::max(best, median({h[k - 1], h[k], h[k + 1]}));
    }
    return best;
}

} // namespace

double Surface::middle(std::size_t k) const {
    return (static_cast<double>(first_bin) + static_cast<double>(k) + 0.5) * bin;
}

double Surface::height_at(double x) const {
    const auto k = bin_of(x, bin) - first_bin;
    return k < 0 || k >= static_cast<std::int64_t>(height.size()) ? -infinite : height[static_cast<std::size_t>(k)];
}

std::int64_t bin_of(double x, double bin) {
    return static_cast<std::int64_t>(std::floor(x / bin));
}

Surface empty_surface(double bin, std::int64_t first, std::int64_t last) {
    Surface surface;
    surface.bin = bin;
    if (last >= first && last - first <= most_bins) {
        surface.first_bin = first;
        surface.height.assign(static_cast<std::size_t>(last - first + 1), -infinite);
    }
    return surface;
}

void raise_surface(Surface& surface, double x, double top) {
    double& height = surface.height[static_cast<std::size_t>(bin_of(x, surface.bin) - surface.first_bin)];
    height = std::max(height, top);
}

double front_position(const Surface& surface, double bed, double rise) {
    const auto k = last_above(surface, bed + rise);
    return k >= 0 ? surface.middle(static_cast<std::size_t>(k)) : no_value;
}

double median_height(const Surface& surface, double from) {
    std::vector<double> heights;
    for (std::size_t k = 0; k < surface.height.size(); ++k) {
        if (std::isfinite(surface.height[k]) && surface.middle(k) >= from) {
            heights.push_back(surface.height[k]);
        }
    }
    return heights.empty() ? 0.0 : median(std::move(heights));
}

SurfaceShape shape_of(const Surface& surface, double bed, double rise) {
    SurfaceShape shape{no_value, no_value, no_value, no_value, no_value};
    shape.front = front_position(surface, bed, rise);
    const auto front = last_above(surface, bed + rise);
    const auto crest = last_above(surface, highest(surface) - rise);
    if (front < 0 || crest < 0) {
        return shape;
    }
    shape.crest = surface.middle(static_cast<std::size_t>(crest));
    std::vector<FitPoint> between;
    for (auto k = static_cast<std::size_t>(crest); static_cast<std::ptrdiff_t>(k) <= front; ++k) {
        if (std::isfinite(surface.height[k])) {
            between.push_back({surface.middle(k), surface.height[k]});
        }
    }
    const auto line = fit_line(between);
    shape.slope = std::isnan(line.slope) ? no_value : std::atan(-line.slope); // a NaN with a sign is printed with it
    shape.residual = line.residual;
    shape.curvature = fit_curvature(between);
    return shape;
}

LayerProfiles layer_profiles(double bin, std::int64_t first_bin, std::int64_t n_bins, int n_layers,
                             std::span<const ProfileGrain> grains) {
    const auto bins = static_cast<std::size_t>(n_bins);
    const auto cells = bins * static_cast<std::size_t>(n_layers);
    LayerProfiles p{std::vector<double>(bins, -infinite), std::vector<double>(cells, -infinite),
                    std::vector<double>(cells, 0.0)};
    std::vector<double> weight(cells, 0.0); // r² is the area but for a factor
    for (const auto& grain : grains) {
        const auto k = static_cast<std::size_t>(bin_of(grain.x[0], bin) - first_bin);
        const auto at = k * static_cast<std::size_t>(n_layers) + static_cast<std::size_t>(grain.layer - 1);
        const double top = grain.x[1] + grain.radius;
        const double r2 = grain.radius * grain.radius;
        p.surface[k] = std::max(p.surface[k], top);
        p.top[at] = std::max(p.top[at], top);
        p.mean[at] += r2 * grain.x[1];
        weight[at] += r2;
    }
    const auto known = [](double top) { return top == -infinite ? no_value : top; };
    std::transform(p.surface.begin(), p.surface.end(), p.surface.begin(), known);
    std::transform(p.top.begin(), p.top.end(), p.top.begin(), known);
    for (std::size_t at = 0; at < cells; ++at) {
        p.mean[at] = weight[at] > 0 ? p.mean[at] / weight[at] : no_value;
    }
    return p;
}

} // namespace nappe
