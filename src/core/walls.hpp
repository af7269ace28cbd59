#pragma once
// Walls: rigid polylines that move as told. A wall is taken apart into features — its segments and its points — so that
// a grain at a joint or at an end touches a point where it should and can not slip between two segments. Every feature
// is one body of the sweep with 1/m = 0; a segment has two sides and so two bodies, told apart by the side on which a
// grain was at the last rebuild.

#include "core/scene.hpp"
#include "core/types.hpp"

#include <vector>

namespace nappe {

/// Where a grain stands to a feature.
template <int D>
struct WallContact {
    bool applies = false;      ///< this feature, and not a neighbouring one, is the nearest part of the wall
    bool through = false;      ///< the grain's centre has gone through the segment since the last rebuild
    double distance = 0;       ///< from the centre to the feature [m]
    Vec<D> n = Vec<D>::Zero(); ///< unit normal from the wall to the grain
};

template <int D>
class Walls {
public:
    /// A piece of a polyline at zero displacement.
    struct Feature {
        int wall = 0;
        bool is_point = false;
        Vec<D> p = Vec<D>::Zero();       ///< the point, or the segment's start
        Vec<D> tangent = Vec<D>::Zero(); ///< segment: unit direction from its start to its end
        double length = 0;               ///< segment [m]
        // A point applies where both segments that meet in it have their nearest point there, asked in their own
        // arithmetic: round-off must leave no gap between a point and its segments.
        bool has_before = false, has_after = false;
        Vec<D> before = Vec<D>::Zero();   ///< direction of the segment that ends in the point
        Vec<D> before_p = Vec<D>::Zero(); ///< that segment's start
        double before_length = 0;         ///< and length [m]
        Vec<D> after = Vec<D>::Zero();    ///< direction of the segment that starts from the point
    };

    explicit Walls(const std::vector<Wall<D>>& walls);

    int n_walls() const { return static_cast<int>(names_.size()); }
    int n_features() const { return static_cast<int>(features_.size()); }
    LocalId n_bodies() const { return static_cast<LocalId>(2 * features_.size()); } ///< sided features
    const Feature& feature(int sided) const { return features_[static_cast<std::size_t>(sided / 2)]; }
    const std::string& name(int wall) const { return names_[static_cast<std::size_t>(wall)]; }
    int material(int wall) const { return materials_[static_cast<std::size_t>(wall)]; }

    /// Current points of a wall [m].
    std::vector<Vec<D>> points(int wall) const;

    /// The sided feature that a grain at x is a candidate of, from where everything stood at the last rebuild.
    int side_of(int feature, const Vec<D>& x_ref) const;

    /// Distance from x to a feature as displaced at the last rebuild [m]; for candidate lists.
    double distance_ref(int feature, const Vec<D>& x) const;

    /// Contact of a grain with a feature at the predicted displacement.
    WallContact<D> contact(int sided, const Vec<D>& x, double radius) const;

    /// Whether a straight way that ends in x, at the predicted displacement, and is `move` long as the wall sees it,
    /// went through the segment from its side `sided`: what `contact` can not tell of a grain that is fast enough to be
    /// far on the other side.
    bool crossed(int sided, const Vec<D>& x, const Vec<D>& move) const;

    // One row per wall, by the same theta-scheme as the grains'.
    std::vector<Vec<D>> offset;     ///< displacement at the start of the step [m]
    std::vector<Vec<D>> offset_mid; ///< predicted [m]
    std::vector<Vec<D>> offset_ref; ///< at the last rebuild [m]
    std::vector<Vec<D>> v;          ///< velocity of this step [m/s]
    std::vector<Vec<D>> v_old;      ///< of the step before [m/s]
    std::vector<double> margin;     ///< see State::margin [m]

private:
    std::vector<std::string> names_;
    std::vector<int> materials_;
    std::vector<std::vector<Vec<D>>> points_;
    std::vector<Feature> features_;
};

/// Velocity a wall is driven with in the step that ends at `time` of loading, in stage `stage` [m/s].
template <int D>
Vec<D> driven_velocity(const Wall<D>& wall, int stage, bool preparing, double time_before, double time);

} // namespace nappe
