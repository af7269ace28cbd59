#pragma once
// The free surface of a bed, the profiles of its layers, and what a geologist reads off them: front, crest, slope and
// curvature. Everything here is Local and works on bins along x that all ranks know.

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace nappe {

/// The free surface: highest point of any grain, per bin of width `bin` along x.
struct Surface {
    std::int64_t first_bin = 0; ///< bin k covers [k bin, (k+1) bin)
    double bin = 0;             ///< [m]
    std::vector<double> height; ///< [m]; -infinity where there is no grain

    double middle(std::size_t k) const; ///< of the k-th bin [m]
    /// Of the bin that x lies in [m]; -infinity beyond the ends.
    double height_at(double x) const;
};

/// A surface covers no more bins than this: one lost grain must not fill the memory.
inline constexpr std::int64_t most_bins = 1'000'000;

/// The bin that x lies in.
std::int64_t bin_of(double x, double bin);

/// No grain yet in bins `first` to `last`; empty if there are none, or more than `most_bins`.
Surface empty_surface(double bin, std::int64_t first, std::int64_t last);

/// Raises the surface to a grain's highest point. Pre: its bin is covered.
void raise_surface(Surface& surface, double x, double top);

/// Middle of the last bin in which the surface stands more than `rise` above `bed`; NaN if there is none [m]. A grain
/// that has rolled or flown ahead in one piece counts: the rule is the fold's (largest x), not a statistic.
double front_position(const Surface& surface, double bed, double rise);

/// Median height of the bins that hold grains and whose middle lies at x >= from: the bed, where less than half of it
/// is covered by a wedge [m]; 0 if there is none.
double median_height(const Surface& surface, double from = -std::numeric_limits<double>::infinity());

/// What stands between the highest part of a surface and its front. NaN where there is no front or too few bins.
struct SurfaceShape {
    double front = 0; ///< x [m]
    double crest = 0; ///< x [m] of the last bin that stands less than `rise` below the highest
    double slope =
        0; ///< fall of the least-squares line from crest to front, an angle [rad]: positive downhill to the right
    double residual = 0;  ///< of that line, root mean square of heights [m]
    double curvature = 0; ///< second derivative of the least-squares parabola [1/m]: positive if concave up
};

/// @param bed height of the ground ahead [m] @param rise height that counts [m]: two mean diameters. The highest is the
/// greatest median of three neighbouring bins: a single grain in the air is no crest.
SurfaceShape shape_of(const Surface& surface, double bed, double rise);

/// A grain as profiles see it. Trivially copyable.
struct ProfileGrain {
    std::array<double, 2> x{}; ///< [m]
    double radius = 0;         ///< [m]
    std::int32_t layer = 0;    ///< from 1
};

/// Some bins of the profiles of all layers: rows are bins, columns layers.
struct LayerProfiles {
    std::vector<double> surface; ///< highest point of any grain [m], NaN without one
    std::vector<double> top;     ///< highest point of the layer's grains [m], NaN without one
    std::vector<double> mean;    ///< their mean height, weighted with areas [m], NaN without one
};

/// The profiles of `n_bins` bins from `first_bin` on, each grain in one of them. Grains come in the order of ids.
LayerProfiles layer_profiles(double bin, std::int64_t first_bin, std::int64_t n_bins, int n_layers,
                             std::span<const ProfileGrain> grains);

} // namespace nappe
