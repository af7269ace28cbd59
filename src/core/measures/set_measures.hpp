#pragma once
// Figures of a set of grains: stress, fabric, coordination, solid fraction, shape, overlap (docs/measures.md, "Sets of
// grains"; seeds/000 eq. 7 to 11). Sums over grains are exact, so that neither their order nor who adds them matters.

#include "core/exact_sum.hpp"
#include "core/measures/grain_loads.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace nappe {

/// All that a set's figures need to know of one grain.
template <int D>
struct MeasuredGrain {
    const FrameGrain<D>* row = nullptr;
    const GrainLoad<D>* load = nullptr;
    bool rattler = false;
    std::int32_t backbone_contacts = 0; ///< with walls and with grains that are no rattlers
    double solid_fraction = 0;          ///< coarse-grained, at the grain's centre
};

/// What later figures are compared with: the set as it was when loading started.
template <int D>
struct SetReference {
    double solid_fraction = 0;      ///< phi0: V is the grains' own area over it
    Vec<D> extent = Vec<D>::Zero(); ///< [m]
};

/// The columns of measures/cell-NAME.csv, in their order. NaN where one has no meaning.
struct SetFigures {
    double p, q, angle; ///< [Pa], [Pa], of the larger principal stress to x, in (-pi/2, pi/2] [rad]
    double fabric_1, fabric_2, fabric_angle; ///< eigenvalues of the fabric, the larger first [1/m²]; as `angle`
    double anisotropy, anisotropy_normalised;
    double coordination, coordination_backbone, rattlers, solid_fraction;
    double lambda_x, lambda_y;
    double overlap_mean, overlap_max; ///< over the smaller radius
    double grains;

    static const std::vector<std::string>& names();
    std::array<double, 17> values() const;
};

/// Adds up the grains of one set. All members are Local; between `add` and `figures` ranks sum up `for_each_sum`,
/// `counts` and take the maximum of `extremes`.
template <int D>
class SetSums {
public:
    SetSums();

    void add(const MeasuredGrain<D>& grain);

    /// Calls f(ExactSum&) for each sum, in the same order on every rank.
    template <class F>
    void for_each_sum(F&& f) {
        for (auto& s : sums_) {
            f(s);
        }
    }
    std::span<std::int64_t> counts() { return counts_; }
    std::span<double> extremes() { return extremes_; } ///< their maximum over ranks is that of the set

    std::int64_t n_grains() const { return counts_[0]; }
    double area() const { return sum(area_at); } ///< of the grains themselves [m²]
    Vec<D> extent() const;                       ///< of their centres (eq. 11) [m]; 0 without grains
    /// Of the coarse-grained field over the grains' own area: sum A / sum(A / phi(x)).
    double solid_fraction() const { return area() / sum(room_at); }

    /// @param h the (sub)step whose impulses these are [s]
    SetFigures figures(const SetReference<D>& at_start, double h) const;

private:
    // Of sums_: moment and fabric row-major, then single ones.
    static constexpr std::size_t fabric_at = std::size_t{D} * D, share_at = 2 * fabric_at, overlap_at = share_at + 1,
                                 area_at = share_at + 2, room_at = share_at + 3, n_sums = share_at + 4;

    double sum(std::size_t k) const { return sums_[k].value(); }
    Eigen::Matrix2d tensor(std::size_t at) const;

    std::vector<ExactSum> sums_;
    std::array<std::int64_t, 4> counts_{};     ///< grains, their contacts, contacts of the backbone, rattlers
    std::array<double, 2 * D + 1> extremes_{}; ///< largest x, -x, y, -y, overlap
};

} // namespace nappe
