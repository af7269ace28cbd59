#pragma once
// What `nappe bench` measures the kernels against: the list-order loop of a textbook, and a triad. Plain data without
// functions or library types, since files compiled for one instruction set include it.

#include <cstdint>

namespace nappe {

/// One contact of the list, 56 bytes; the symbols of DiskBatch. n points from b to a.
struct ListContact {
    double nx, ny;     ///< unit normal
    double bias;       ///< b [m/s]
    double m_eff;      ///< 1/W_nn [kg]
    double r_n, r_t;   ///< impulses [N s]
    std::int32_t a, b; ///< rows of bodies
};

/// A body of the list: v_x, v_y, s [m/s], 1/m [1/kg].
struct ListBody {
    double vx, vy, s, inv_m;
};

/// Both loops, compiled with the flags of one instruction set's sweep.
struct BenchLoops {
    const char* name;
    /// One Gauss–Seidel pass over n contacts, one after the other. @param mu friction coefficient of all
    void (*relax_list)(ListContact* contacts, std::int64_t n, double mu, ListBody* u);
    /// a[i] = b[i] + s c[i]; arrays of n doubles on 64-byte boundaries.
    void (*triad)(double* a, const double* b, const double* c, double s, std::int64_t n);
};

/// Bytes that a triad is charged with per element: two read, one written. (What the cache fetches of a before it is
/// overwritten is not counted, as in STREAM.)
inline constexpr std::int64_t triad_bytes = 24;

/// The loops compiled like the fastest sweep of this machine.
const BenchLoops& bench_loops();

} // namespace nappe
