#pragma once
// The contact problem of one step for disks: from frozen candidates, those that may act in this step, packed for the
// sweep.

#include "core/contact_set.hpp"
#include "core/scene.hpp"
#include "core/state.hpp"
#include "core/walls.hpp"
#include "solver/disk_batch.hpp"

#include <limits>
#include <vector>

namespace nappe {

/// Friction and restitution of every pair of materials, as a table.
struct PairLaws {
    explicit PairLaws(const Scene<2>& scene);

    double friction(int a, int b) const { return friction_[static_cast<std::size_t>(a * n_ + b)]; }
    double restitution(int a, int b) const { return restitution_[static_cast<std::size_t>(a * n_ + b)]; }

    bool uniform = true; ///< one friction coefficient serves all pairs
    double uniform_friction = 0;
    bool any_restitution = false; ///< else no approach velocity is ever computed

private:
    int n_ = 0;
    std::vector<double> friction_, restitution_;
};

/// Distances between convergence and truth: largest and RMS of |W (r - P(r - u/W))| over active contacts [m/s], to be
/// divided by a velocity scale (docs/notation.md, "residual").
struct RawResidual {
    double largest_squared = 0;
    double sum_squared = 0; ///< of one tile, in the order of its contacts
    std::int64_t contacts = 0;
};

/// What packing met; ids rather than exceptions, since all ranks must hear of it together.
struct PackFaults {
    static constexpr GlobalId none = std::numeric_limits<GlobalId>::max();
    GlobalId through_wall = none; ///< lowest id of a grain whose centre went through a wall
    int wall = -1;
};

class DiskContacts {
public:
    DiskContacts(const Scene<2>& scene, const DiskKernels& kernels) : laws_(scene), kernels_(kernels) {}

    /// Local. Geometry of every candidate at the predicted positions; those that may act in a step of h are packed with
    /// their impulses from `candidates`. Which those are: a gap below what the pair could close at twice its present
    /// speed of approach, plus 1 % of the radii; `activate_all` packs every candidate. Pre: u is the free velocity,
    /// u_old that of the step's start.
    PackFaults pack(const State<2>& state, const CandidateSet<2>& candidates, const Walls<2>& walls, double h,
                    bool activate_all);

    /// Local. Whether a candidate that was left out would have had to act, at velocities u: then the step must be
    /// redone.
    bool missed_any(const State<2>& state, const CandidateSet<2>& candidates, const Walls<2>& walls, double h) const;

    void relax(std::size_t tile, std::vector<BodyVelocity<2>>& u) {
        const Range& r = ranges_[tile];
        kernels_.relax(batches_.data() + r.begin, laws_.uniform ? nullptr : friction_.data() + r.begin, r.end - r.begin,
                       laws_.uniform_friction, u.data()->v.data());
    }

    void apply(std::size_t tile, std::vector<BodyVelocity<2>>& u) const {
        const Range& r = ranges_[tile];
        kernels_.apply(batches_.data() + r.begin, r.end - r.begin, u.data()->v.data());
    }

    /// Local. One tile's residual at velocities u.
    RawResidual residual(std::size_t tile, const std::vector<BodyVelocity<2>>& u) const;

    /// Local. Sum of squared relative velocities over one tile's touching contacts [m²/s²] and their number.
    std::pair<double, std::int64_t> touching_speed(std::size_t tile, const std::vector<BodyVelocity<2>>& u) const;

    /// Local. Puts the impulses back to their candidates; those left out have none.
    void store(CandidateSet<2>& candidates) const;

    std::int64_t n_active() const { return n_active_; }
    std::int64_t n_active(std::size_t tile) const { return ranges_[tile].active; }
    std::size_t n_tiles() const { return ranges_.size(); }

    /// Calls f(a, b, n, impulse) for the packed contacts of a tile, in the order of the sweep.
    template <class F>
    void for_each(std::size_t tile, F&& f) const {
        for (auto k = ranges_[tile].begin; k < ranges_[tile].end; ++k) {
            const DiskBatch& batch = batches_[static_cast<std::size_t>(k)];
            for (int l = 0; l < n_lanes; ++l) {
                if (source_[static_cast<std::size_t>(k * n_lanes + l)] >= 0) {
                    f(batch.a[l], batch.b[l], Vec<2>(batch.nx[l], batch.ny[l]), batch.r_n[l], batch.r_t[l]);
                }
            }
        }
    }

    /// Of a packed contact where one friction coefficient serves all.
    static constexpr std::size_t bytes_per_packed = sizeof(DiskBatch) / n_lanes + sizeof(std::int32_t);

    std::size_t bytes_per_contact() const { return bytes_per_packed + (laws_.uniform ? 0 : sizeof(double)); }
    const char* instruction_set() const { return kernels_.name; }

private:
    struct Range {
        std::int64_t begin = 0, end = 0, active = 0;
    };

    PairLaws laws_;
    const DiskKernels& kernels_;
    std::vector<DiskBatch> batches_;
    std::vector<FrictionBatch> friction_; ///< empty if laws_.uniform
    std::vector<std::int32_t> source_;    ///< candidate of every lane, -1 for null contacts
    std::vector<Range> ranges_;           ///< batches of every tile
    std::vector<std::int32_t> left_out_;  ///< candidates not packed that could still come to act
    std::int64_t n_active_ = 0;
};

} // namespace nappe
