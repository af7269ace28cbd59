// The inner contact loop, one source for all instruction sets: included by disk_sweep_*.cpp, each compiled with its own
// flags. Everything here is in an unnamed namespace and uses no library code, so that no copy of a function compiled
// for AVX-512 can be taken by the linker for the rest of the program.
//
// Signorini–Coulomb on impulses, one contact (seeds/000 eq. 5, 6 and the bias of docs/notation.md):
//     r_n <- max(0, r_n - (v_n + b) / W_nn),   r_t <- clamp(r_t - v_t / W_tt, -mu r_n, mu r_n)
// with W_nn = 1/m_a + 1/m_b and, for disks (I = m r²/2), W_tt = 3 W_nn, W_nt = 0. With s = r x spin the relative
// velocity is
//     v_n = n·(v_a - v_b),   v_t = t·(v_a - v_b) - (s_a + s_b),   t = (-n_y, n_x),
// and an impulse changes v by ±(r_n n + r_t t)/m and s by -2 r_t/m on both sides.
// Selections are written `a > b ? a : b`, alike in scalar and vector code.

#include "solver/disk_batch.hpp"

namespace nappe {
namespace {

// A register holds `width` doubles; a batch of eight contacts takes 8 / width of them. What wide shuffles would be
// emulated by scalar moves on a narrower instruction set, so the transposition of bodies into lanes is written once per
// width.
#if defined(__AVX512F__)
constexpr int width = 8;
#elif defined(__AVX2__)
constexpr int width = 4;
#else
constexpr int width = 2;
#endif

typedef double Lane __attribute__((vector_size(8 * width), may_alias)); // one number of `width` contacts

static_assert(n_lanes % width == 0);

struct Bodies {
    Lane vx, vy, s, inv_m;
};

inline __attribute__((always_inline)) Lane load(const double* p) {
    return *reinterpret_cast<const Lane*>(p);
}

inline __attribute__((always_inline)) void store(double* p, const Lane& v) {
    *reinterpret_cast<Lane*>(p) = v;
}

#if defined(__AVX512F__) || defined(__AVX2__)
typedef double Row __attribute__((vector_size(32), may_alias)); // a body: v_x, v_y, s, 1/m

inline __attribute__((always_inline)) Row row(const double* u, std::int32_t i) {
    return *reinterpret_cast<const Row*>(u + 4 * static_cast<std::int64_t>(i));
}

inline __attribute__((always_inline)) void put(double* u, std::int32_t i, const Row& r) {
    *reinterpret_cast<Row*>(u + 4 * static_cast<std::int64_t>(i)) = r;
}
#endif

// gather: bodies i[0] … i[width-1], transposed into lanes. scatter: back; lanes that name one unmovable body all write
// what was there.
#if defined(__AVX512F__)
inline __attribute__((always_inline)) Bodies gather(const double* u, const std::int32_t* i) {
    const Lane a = __builtin_shufflevector(row(u, i[0]), row(u, i[1]), 0, 1, 2, 3, 4, 5, 6, 7);
    const Lane b = __builtin_shufflevector(row(u, i[2]), row(u, i[3]), 0, 1, 2, 3, 4, 5, 6, 7);
    const Lane c = __builtin_shufflevector(row(u, i[4]), row(u, i[5]), 0, 1, 2, 3, 4, 5, 6, 7);
    const Lane d = __builtin_shufflevector(row(u, i[6]), row(u, i[7]), 0, 1, 2, 3, 4, 5, 6, 7);
    const Lane ab_v = __builtin_shufflevector(a, b, 0, 4, 8, 12, 1, 5, 9, 13);
    const Lane cd_v = __builtin_shufflevector(c, d, 0, 4, 8, 12, 1, 5, 9, 13);
    const Lane ab_s = __builtin_shufflevector(a, b, 2, 6, 10, 14, 3, 7, 11, 15);
    const Lane cd_s = __builtin_shufflevector(c, d, 2, 6, 10, 14, 3, 7, 11, 15);
    return {__builtin_shufflevector(ab_v, cd_v, 0, 1, 2, 3, 8, 9, 10, 11),
            __builtin_shufflevector(ab_v, cd_v, 4, 5, 6, 7, 12, 13, 14, 15),
            __builtin_shufflevector(ab_s, cd_s, 0, 1, 2, 3, 8, 9, 10, 11),
            __builtin_shufflevector(ab_s, cd_s, 4, 5, 6, 7, 12, 13, 14, 15)};
}

inline __attribute__((always_inline)) void scatter(double* u, const std::int32_t* i, const Bodies& w) {
    const Lane ab_v = __builtin_shufflevector(w.vx, w.vy, 0, 1, 2, 3, 8, 9, 10, 11);
    const Lane cd_v = __builtin_shufflevector(w.vx, w.vy, 4, 5, 6, 7, 12, 13, 14, 15);
    const Lane ab_s = __builtin_shufflevector(w.s, w.inv_m, 0, 1, 2, 3, 8, 9, 10, 11);
    const Lane cd_s = __builtin_shufflevector(w.s, w.inv_m, 4, 5, 6, 7, 12, 13, 14, 15);
    const Lane a = __builtin_shufflevector(ab_v, ab_s, 0, 4, 8, 12, 1, 5, 9, 13);
    const Lane b = __builtin_shufflevector(ab_v, ab_s, 2, 6, 10, 14, 3, 7, 11, 15);
    const Lane c = __builtin_shufflevector(cd_v, cd_s, 0, 4, 8, 12, 1, 5, 9, 13);
    const Lane d = __builtin_shufflevector(cd_v, cd_s, 2, 6, 10, 14, 3, 7, 11, 15);
    put(u, i[0], __builtin_shufflevector(a, a, 0, 1, 2, 3));
    put(u, i[1], __builtin_shufflevector(a, a, 4, 5, 6, 7));
    put(u, i[2], __builtin_shufflevector(b, b, 0, 1, 2, 3));
    put(u, i[3], __builtin_shufflevector(b, b, 4, 5, 6, 7));
    put(u, i[4], __builtin_shufflevector(c, c, 0, 1, 2, 3));
    put(u, i[5], __builtin_shufflevector(c, c, 4, 5, 6, 7));
    put(u, i[6], __builtin_shufflevector(d, d, 0, 1, 2, 3));
    put(u, i[7], __builtin_shufflevector(d, d, 4, 5, 6, 7));
}
#elif defined(__AVX2__)
inline __attribute__((always_inline)) Bodies gather(const double* u, const std::int32_t* i) {
    const Row a = row(u, i[0]), b = row(u, i[1]), c = row(u, i[2]), d = row(u, i[3]);
    const Row ab_even = __builtin_shufflevector(a, b, 0, 4, 2, 6), ab_odd = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const Row cd_even = __builtin_shufflevector(c, d, 0, 4, 2, 6), cd_odd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    return {__builtin_shufflevector(ab_even, cd_even, 0, 1, 4, 5), __builtin_shufflevector(ab_odd, cd_odd, 0, 1, 4, 5),
            __builtin_shufflevector(ab_even, cd_even, 2, 3, 6, 7), __builtin_shufflevector(ab_odd, cd_odd, 2, 3, 6, 7)};
}

inline __attribute__((always_inline)) void scatter(double* u, const std::int32_t* i, const Bodies& w) {
    const Row ac_v = __builtin_shufflevector(w.vx, w.vy, 0, 4, 2, 6),
              bd_v = __builtin_shufflevector(w.vx, w.vy, 1, 5, 3, 7);
    const Row ac_s = __builtin_shufflevector(w.s, w.inv_m, 0, 4, 2, 6);
    const Row bd_s = __builtin_shufflevector(w.s, w.inv_m, 1, 5, 3, 7);
    put(u, i[0], __builtin_shufflevector(ac_v, ac_s, 0, 1, 4, 5));
    put(u, i[1], __builtin_shufflevector(bd_v, bd_s, 0, 1, 4, 5));
    put(u, i[2], __builtin_shufflevector(ac_v, ac_s, 2, 3, 6, 7));
    put(u, i[3], __builtin_shufflevector(bd_v, bd_s, 2, 3, 6, 7));
}
#else
inline __attribute__((always_inline)) Bodies gather(const double* u, const std::int32_t* i) {
    const double* a = u + 4 * static_cast<std::int64_t>(i[0]);
    const double* b = u + 4 * static_cast<std::int64_t>(i[1]);
    const Lane a_v = load(a), b_v = load(b), a_s = load(a + 2), b_s = load(b + 2);
    return {__builtin_shufflevector(a_v, b_v, 0, 2), __builtin_shufflevector(a_v, b_v, 1, 3),
            __builtin_shufflevector(a_s, b_s, 0, 2), __builtin_shufflevector(a_s, b_s, 1, 3)};
}

inline __attribute__((always_inline)) void scatter(double* u, const std::int32_t* i, const Bodies& w) {
    double* a = u + 4 * static_cast<std::int64_t>(i[0]);
    double* b = u + 4 * static_cast<std::int64_t>(i[1]);
    store(a, __builtin_shufflevector(w.vx, w.vy, 0, 2));
    store(b, __builtin_shufflevector(w.vx, w.vy, 1, 3));
    store(a + 2, __builtin_shufflevector(w.s, w.inv_m, 0, 2));
    store(b + 2, __builtin_shufflevector(w.s, w.inv_m, 1, 3));
}
#endif

/// The impulses d_n, d_t act on both bodies of each lane.
inline __attribute__((always_inline)) void push(Bodies& a, Bodies& b, const Lane& nx, const Lane& ny, const Lane& d_n,
                                                const Lane& d_t) {
    const Lane px = d_n * nx - d_t * ny;
    const Lane py = d_n * ny + d_t * nx;
    const Lane spin = d_t + d_t;
    a.vx += px * a.inv_m;
    a.vy += py * a.inv_m;
    a.s -= spin * a.inv_m;
    b.vx -= px * b.inv_m;
    b.vy -= py * b.inv_m;
    b.s -= spin * b.inv_m;
}

template <bool Mixed>
inline __attribute__((always_inline)) void relax_all(DiskBatch* batches, const FrictionBatch* mixed, std::int64_t n,
                                                     double mu_uniform, double* u) {
    const Lane zero = {};
    const double third = 1.0 / 3.0;
    for (std::int64_t k = 0; k < n; ++k) {
        DiskBatch& batch = batches[k];
        for (int l = 0; l < n_lanes; l += width) {
            Bodies a = gather(u, batch.a + l);
            Bodies b = gather(u, batch.b + l);
            const Lane nx = load(batch.nx + l), ny = load(batch.ny + l), m = load(batch.m_eff + l);
            const Lane r_n = load(batch.r_n + l), r_t = load(batch.r_t + l);
            const Lane dvx = a.vx - b.vx, dvy = a.vy - b.vy;
            const Lane v_n = nx * dvx + ny * dvy;
            const Lane v_t = (nx * dvy - ny * dvx) - (a.s + b.s);
            const Lane wanted_n = r_n - (v_n + load(batch.bias + l)) * m;
            const Lane new_n = wanted_n > zero ? wanted_n : zero;
            const Lane limit = Mixed ? load(mixed[k].mu + l) * new_n : mu_uniform * new_n;
            const Lane wanted_t = r_t - v_t * (m * third);
            const Lane above = wanted_t > limit ? limit : wanted_t;
            const Lane new_t = above < -limit ? -limit : above;
            store(batch.r_n + l, new_n);
            store(batch.r_t + l, new_t);
            push(a, b, nx, ny, new_n - r_n, new_t - r_t);
            scatter(u, batch.a + l, a);
            scatter(u, batch.b + l, b);
        }
    }
}

void relax(DiskBatch* batches, const FrictionBatch* mixed, std::int64_t n, double mu, double* u) {
    if (mixed != nullptr) {
        relax_all<true>(batches, mixed, n, mu, u);
    } else {
        relax_all<false>(batches, mixed, n, mu, u);
    }
}

void apply(const DiskBatch* batches, std::int64_t n, double* u) {
    for (std::int64_t k = 0; k < n; ++k) {
        const DiskBatch& batch = batches[k];
        for (int l = 0; l < n_lanes; l += width) {
            Bodies a = gather(u, batch.a + l);
            Bodies b = gather(u, batch.b + l);
            push(a, b, load(batch.nx + l), load(batch.ny + l), load(batch.r_n + l), load(batch.r_t + l));
            scatter(u, batch.a + l, a);
            scatter(u, batch.b + l, b);
        }
    }
}

} // namespace
} // namespace nappe
