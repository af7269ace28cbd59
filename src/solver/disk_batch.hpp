#pragma once
// What the sweep streams through: contacts of disks (and of disks with walls) in batches that share no grain. Plain
// data without functions or library types, since files compiled for one instruction set include it.

#include <cstdint>

namespace nappe {

/// Contacts per batch: the doubles of a 512-bit register. The same for every instruction set, so that all run one
/// order.
inline constexpr int n_lanes = 8;

/// One batch, 48 bytes a contact: what every law needs. n points from b to a. A null contact pads a batch: both bodies
/// null, m_eff = 0. A contact that sleeps keeps its lane, with m_eff = 0 and no impulses: it changes nothing.
/// (Rejected: the normal as an angle or in single precision — the same cache lines and other bits; 1/W_tt beside
/// 1/W_nn — for disks it is a third of it.)
struct alignas(64) DiskBatch {
    double nx[n_lanes], ny[n_lanes];      ///< unit normal
    double bias[n_lanes];                 ///< b [m/s], docs/notation.md
    double m_eff[n_lanes];                ///< 1/W_nn [kg]
    double r_n[n_lanes];                  ///< normal impulse [N s]
    std::uint32_t a[n_lanes], b[n_lanes]; ///< bodies: 4 x row, the first of a body's four doubles in `u` and `mid`
};

/// Tangential impulses of a batch, kept only by scenes with friction.
struct alignas(64) TangentBatch {
    double r_t[n_lanes]; ///< [N s]
};

/// Friction coefficients of a batch, kept only by scenes whose laws differ in it.
struct alignas(64) FrictionBatch {
    double mu[n_lanes];
};

/// What the attraction of a batch's bonded contacts may reach, gamma h >= 0, kept only while cohesion acts; 0 where the
/// plain law does.
struct alignas(64) CohesionBatch {
    double most[n_lanes]; ///< [N s]
};

/// Gaps of a batch, kept only where normals serve for several substeps.
struct alignas(64) KeptGapBatch {
    double gap[n_lanes]; ///< [m]
};

/// A batch while it is swept over in single precision, 32 bytes a contact. Indices count floats of the velocities then.
struct alignas(64) SingleBatch {
    float nx[n_lanes], ny[n_lanes], bias[n_lanes], m_eff[n_lanes], r_n[n_lanes], r_t[n_lanes];
    std::uint32_t a[n_lanes], b[n_lanes];
};

/// Springs and dashpots of a batch, kept only while contacts are smooth.
struct alignas(64) SpringBatch {
    double k_n[n_lanes], k_s[n_lanes]; ///< [N/m]
    double c_n[n_lanes], c_s[n_lanes]; ///< [N s/m]
    double mu[n_lanes];
};

struct SearchBatch;

/// n batches that follow each other, and what the scene's laws add to each of them: nullptr where nothing.
struct BatchSpan {
    DiskBatch* contacts = nullptr;
    std::int64_t n = 0;
    TangentBatch* tangent = nullptr;         ///< nullptr: no friction, and no tangential part of anything
    const FrictionBatch* friction = nullptr; ///< nullptr: `mu` holds for all
    const CohesionBatch* cohesion = nullptr; ///< nullptr: the plain law
    double mu = 0;
    KeptGapBatch* kept_gaps = nullptr; ///< nullptr: every substep measures its own
    SearchBatch* summed = nullptr;     ///< impulses of the substeps before, nullptr as well
};

/// One more number for each impulse of a batch: the sum over substeps with the same normals, or what a method that looks
/// back keeps.
struct alignas(64) SearchBatch {
    double n[n_lanes], t[n_lanes]; ///< [N s]
};

/// Terms of a sum are rounded to multiples of a unit so coarse that they add up without any error: then lanes may hold
/// them in whatever order (core/rounded_sum.hpp).
struct TermRounding {
    double magic = 0; ///< 3/2 2^52 units: adding and subtracting it rounds
    double most = 0;  ///< larger terms count as this
};

/// What a pass of a method adds up over its contacts, W the contact's own block, z what it ended with, y what it started
/// from, x what it had before: both in J.
struct StepSums {
    double squared = 0; ///< of W (z - y)²
    double along = 0;   ///< of W (z - y) (z - x)
};

/// Where eight pairs of disks stand; of a pair with a wall, size and gap are NaN.
struct alignas(64) GapBatch {
    double nx[n_lanes], ny[n_lanes]; ///< unit normal from b to a
    double gap[n_lanes];             ///< [m]
    double size[n_lanes];            ///< r_a + r_b [m]
    double v[n_lanes];               ///< normal relative velocity at `u`, positive: opening [m/s]
    double v_old[n_lanes];           ///< at `u_old`
};

/// What `refresh` found.
struct Refreshed {
    std::int64_t awake = 0;
    double deepest = 0; ///< largest overlap between disks, over the smaller radius
};

/// What the kernels read of bodies: four doubles a body in each array, see BodyVelocity<2> and BodyPlace<2>.
struct BodyArrays {
    const double* mid;
    const double* u;
    const double* u_old;
};

/// What smooth contacts are found from: where bodies stand and how fast they are as a step begins, as above.
struct SmoothBodies {
    const double* mid;
    const double* u_old;
};

/// A step of smooth contacts.
struct SmoothStep {
    SmoothBodies bodies;
    double* u;    ///< velocities that forces act on
    double h;     ///< [s]
    double share; ///< of the smaller radius: overlaps beyond it are told of
    bool uniform; ///< all springs and friction are those of the first lane, and c_s = c_n
};

/// What `press` met.
struct SmoothTally {
    double touching = 0; ///< contacts of disks or walls that overlap
    double deeper = 0;   ///< than `share`, the deepest; 0 if none is [m]
};

/// Grains as the kernels that move them see them; rows of `mid`, `u` and `u_old` are four doubles, of `x` and `damping` two.
struct GrainArrays {
    double *x, *mid, *u, *u_old;
    double* rotation;      ///< nullptr where nothing turns
    const double* damping; ///< C h / 2m and C* h / 2I
};

/// How grains end a step.
struct GrainMotion {
    double fastest_squared = 0; ///< [m²/s²]
    double zeros = 0;           ///< NaN if any of them is not finite
    double kinetic = 0;         ///< [J]
    double momentum[2] = {};    ///< [N s]
};

/// Doubles of `u` that will be asked for next.
struct BodyRange {
    std::int64_t begin = 0, end = 0;
};

/// The kernels of one instruction set.
struct DiskKernels {
    const char* name;
    /// One Gauss–Seidel pass over the batches, in order. With cohesion r_n goes down to -most, friction up to
    /// mu (r_n + most); without friction spins are left as they are.
    void (*relax)(const BatchSpan& batches, double* u, BodyRange soon);
    /// The same from impulses moved on: y = r + beta (r - before), before <- r, r <- z. Pre: u has moved on alike.
    StepSums (*relax_ahead)(const BatchSpan& batches, SearchBatch* before, double beta, const TermRounding& rounding,
                            double* u, BodyRange soon);
    /// The same, moved on along a direction that all y have made: y = r + beta p, p <- beta p + r - from, from <- y.
    StepSums (*relax_along)(const BatchSpan& batches, SearchBatch* from, SearchBatch* direction, double beta,
                            const TermRounding& rounding, double* u, BodyRange soon);
    /// A projected gradient step from y = r + beta (r - before): z = P(y - step (v + b) / W), v at the velocities `at`
    /// of y; before <- r, r <- z; adds the effect of z - y to `u`.
    StepSums (*project)(const BatchSpan& batches, SearchBatch* before, double beta, double step,
                        const TermRounding& rounding, const double* at, double* u);
    /// cpg.hpp: z <- T(g / W) and p <- T(p), g at the velocities `at`; adds the effect of z to `of_z`. Sums: (g, z).
    StepSums (*gradient)(const BatchSpan& batches, SearchBatch* z, SearchBatch* p, const TermRounding& rounding,
                         const double* at, double* of_z);
    /// p <- z + beta p; adds the effect of p to `of_p`. Sums: (g, p) in `along`.
    StepSums (*turn)(const BatchSpan& batches, const SearchBatch* z, SearchBatch* p, double beta,
                     const TermRounding& rounding, const double* at, double* of_p);
    /// r <- P(r + alpha p); adds the effect of the change to u.
    void (*go_along)(const BatchSpan& batches, const SearchBatch* p, double alpha, double* u);
    /// Adds the effect of the impulses that the batches hold to the velocities: a warm start.
    void (*apply)(const BatchSpan& batches, double* u);
    /// New normals and biases (inelastic law) of batches that stay as they are, for a step of h. Contacts of disks that
    /// sleep (DiskContacts' rule) lose impulses and m_eff, those that wake get it back; what is bonded never sleeps.
    /// Counts those that are awake. Lanes of walls count as awake; what they get is for the caller to overwrite.
    /// @param look seconds ahead that the rule looks: those for which normals are to serve
    Refreshed (*refresh)(const BatchSpan& batches, const BodyArrays& bodies, double h, double look);
    /// Gaps and biases (inelastic law) after bodies moved for a time h at velocities u, normals as they are; impulses are
    /// added to `summed`. Pre: gaps are kept.
    void (*advance)(const BatchSpan& batches, const double* u, double h);
    /// Batches whose frictionless solution moves bodies so that `share` of each overlap at the end of a step h at velocities
    /// u goes and none comes; they hold no impulses. Pre: gaps are kept.
    void (*begin_correction)(const BatchSpan& batches, DiskBatch* out, const double* u, double h, double share);
    /// `relax`; returns the largest squared change of a contact's impulses, times its own block: the squared residual that
    /// the pass met [m²/s²].
    double (*relax_watched)(const BatchSpan& batches, double* u, BodyRange soon);
    /// Pairs which[0] … which[n-1] of the lists a and b (rows); `which` nullptr: the first n. Writes (n + 7) / 8
    /// batches; lanes past n repeat the last pair.
    void (*gaps)(const std::int32_t* which, std::int64_t n, const std::int32_t* a, const std::int32_t* b,
                 const BodyArrays& bodies, GapBatch* out);
    /// Cundall's contacts (disk_smooth.inl), their forces times h: the effect is added to step.u. Tangential springs are
    /// read in r_t and written to `after`. Where of_walls[k] is not 0, batch k has lanes of walls: their normals and gaps
    /// are in it, and its impulses are stored, r_n and in `summed` what the spring has not of the tangential one. Padding
    /// and pairs apart have no effect.
    /// Pre: gaps and sums are kept; of_walls may be nullptr.
    SmoothTally (*press)(const BatchSpan& batches, const SpringBatch* springs, TangentBatch* after,
                         const unsigned char* of_walls, const SmoothStep& step);
    /// What `press` found and did not store: gaps, normals, impulses. r_t: the springs after it. Returns the largest
    /// overlap over the smaller radius.
    double (*record)(const BatchSpan& batches, const SpringBatch* springs, const SmoothBodies& bodies, double h);
    /// Rows begin … end - 1 start a step: u_old and mid as they stand, with the rotation as a body's fourth double, and
    /// to `u` what comes of gravity (`gained`, [m/s]) and of half the damping.
    void (*open_grains)(const GrainArrays& grains, std::int64_t begin, std::int64_t end, const double* gained);
    /// They end it, after all forces: the other half of the damping, positions and rotations.
    GrainMotion (*close_grains)(const GrainArrays& grains, std::int64_t begin, std::int64_t end, double h);
    /// The batches, rounded.
    void (*round_batches)(const BatchSpan& batches, SingleBatch* contacts);
    /// `relax` in single precision; the law's limits are those of `batches`.
    void (*relax_single)(const BatchSpan& batches, SingleBatch* contacts, float* u, BodyRange soon);
    /// r <- P(what single precision found); adds the effect of the change to u, in double.
    void (*settle_single)(const BatchSpan& batches, const SingleBatch* contacts, double* u);
};

/// The fastest set this processor has, or the one named in `wanted` ("scalar", "portable", "avx2", "avx512").
/// Throws InputError if `wanted` is unknown or missing on this machine.
const DiskKernels& disk_kernels(const char* wanted = nullptr);

} // namespace nappe
