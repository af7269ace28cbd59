#pragma once
// What the sweep streams through: contacts of disks (and of disks with walls) in batches that share no grain. Plain
// data without functions or library types, since files compiled for one instruction set include it.

#include <cstdint>

namespace nappe {

/// Contacts per batch: the doubles of a 512-bit register. The same for every instruction set, so that all run one
/// order.
inline constexpr int n_lanes = 8;

/// One batch, 56 bytes a contact. n points from b to a. A null contact pads the last batch of a class: both bodies
/// null, m_eff = 0. (Rejected: the normal as an angle or in single precision — the same cache lines and other bits;
/// 1/W_tt beside 1/W_nn — for disks it is a third of it.)
struct alignas(64) DiskBatch {
    double nx[n_lanes], ny[n_lanes];     ///< unit normal
    double bias[n_lanes];                ///< b [m/s], docs/notation.md
    double m_eff[n_lanes];               ///< 1/W_nn [kg]
    double r_n[n_lanes];                 ///< normal impulse [N s]
    double r_t[n_lanes];                 ///< tangential impulse [N s]
    std::int32_t a[n_lanes], b[n_lanes]; ///< rows of bodies
};

/// Friction coefficients of a batch, kept only by scenes whose laws differ in it.
struct alignas(64) FrictionBatch {
    double mu[n_lanes];
};

/// The kernels of one instruction set. `u` is the array of BodyVelocity<2>: four doubles v_x, v_y, s, 1/m a body.
/// `mixed` is nullptr where one `mu` holds for all.
struct DiskKernels {
    const char* name;
    /// One Gauss–Seidel pass over n batches, in order.
    void (*relax)(DiskBatch* batches, const FrictionBatch* mixed, std::int64_t n, double mu, double* u);
    /// Adds the effect of the impulses that the batches hold to the velocities: a warm start.
    void (*apply)(const DiskBatch* batches, std::int64_t n, double* u);
};

/// The fastest set this processor has, or the one named in `wanted` ("portable", "avx2", "avx512").
/// Throws InputError if `wanted` is unknown or missing on this machine.
const DiskKernels& disk_kernels(const char* wanted = nullptr);

} // namespace nappe
