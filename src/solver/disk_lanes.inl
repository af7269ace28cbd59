// Registers of contacts and the bodies that go with them, one source for all instruction sets. Everything here and in
// what includes it is in an unnamed namespace and uses no library code, so that no copy of a function compiled for AVX-512
// can be taken by the linker for the rest of the program.

#include "solver/disk_batch.hpp"

#if defined(__AVX2__)
#include <immintrin.h> // intrinsics only: no function of it is left as a symbol
#endif

namespace nappe {
namespace {

// A register holds `width` doubles; a batch of eight contacts takes 8 / width of them. What wide shuffles would be
// emulated by scalar moves on a narrower instruction set, so the transposition of bodies into lanes is written once per
// width. NAPPE_SCALAR asks for one lane: plain arithmetic in the same order.
#if defined(__AVX512F__)
constexpr int width = 8;
#elif defined(__AVX2__)
constexpr int width = 4;
#elif defined(NAPPE_SCALAR)
constexpr int width = 1;
#else
constexpr int width = 2;
#endif

#if defined(NAPPE_SCALAR)
typedef double Lane;
#else
typedef double Lane __attribute__((vector_size(8 * width), may_alias)); // one number of `width` contacts
#endif

static_assert(n_lanes % width == 0);

#define NAPPE_INLINE inline __attribute__((always_inline))

/// Four numbers of `width` bodies: of velocities v_x, v_y, s, 1/m; of places x, y, radius and nothing.
struct Bodies {
    Lane x, y, s, w;
};

NAPPE_INLINE Lane load(const double* p) {
    return *reinterpret_cast<const Lane*>(p);
}

NAPPE_INLINE void store(double* p, const Lane& v) {
    *reinterpret_cast<Lane*>(p) = v;
}

#if defined(NAPPE_SCALAR)
NAPPE_INLINE Lane root(Lane v) {
    return __builtin_sqrt(v);
}

NAPPE_INLINE double sum_of(Lane v) {
    return v;
}
#else
NAPPE_INLINE Lane root(const Lane& v) {
    Lane r;
    for (int k = 0; k < width; ++k) {
        r[k] = __builtin_sqrt(v[k]);
    }
    return r;
}

NAPPE_INLINE double sum_of(const Lane& v) {
    double sum = 0;
    for (int k = 0; k < width; ++k) {
        sum += v[k];
    }
    return sum;
}
#endif

// gather: bodies i[0] … i[width-1], transposed into lanes. scatter: back; lanes that name one unmovable body all write
// what was there. An index counts doubles.
#if defined(__AVX512F__)
typedef double Row __attribute__((vector_size(32), may_alias)); // a body

NAPPE_INLINE __m256d row(const double* u, std::uint32_t i) {
    return _mm256_load_pd(u + i);
}

/// Bodies i and j in the lower and upper half: a load and an insert from memory, no shuffle.
NAPPE_INLINE Lane pair(const double* u, std::uint32_t i, std::uint32_t j) {
    return (Lane)_mm512_insertf64x4(_mm512_castpd256_pd512(row(u, i)), row(u, j), 1);
}

NAPPE_INLINE void put(double* u, std::uint32_t i, std::uint32_t j, const Lane& v) {
    _mm256_store_pd(u + i, _mm512_castpd512_pd256((__m512d)v));
    _mm256_store_pd(u + j, _mm512_extractf64x4_pd((__m512d)v, 1));
}

NAPPE_INLINE Bodies gather(const double* u, const std::uint32_t* i) {
    const Lane a = pair(u, i[0], i[2]), b = pair(u, i[1], i[3]), c = pair(u, i[4], i[6]), d = pair(u, i[5], i[7]);
    const Lane ab_xs = __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
    const Lane ab_yw = __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
    const Lane cd_xs = __builtin_shufflevector(c, d, 0, 8, 2, 10, 4, 12, 6, 14);
    const Lane cd_yw = __builtin_shufflevector(c, d, 1, 9, 3, 11, 5, 13, 7, 15);
    return {__builtin_shufflevector(ab_xs, cd_xs, 0, 1, 4, 5, 8, 9, 12, 13),
            __builtin_shufflevector(ab_yw, cd_yw, 0, 1, 4, 5, 8, 9, 12, 13),
            __builtin_shufflevector(ab_xs, cd_xs, 2, 3, 6, 7, 10, 11, 14, 15),
            __builtin_shufflevector(ab_yw, cd_yw, 2, 3, 6, 7, 10, 11, 14, 15)};
}

NAPPE_INLINE void scatter(double* u, const std::uint32_t* i, const Bodies& v) {
    const Lane even_xy = __builtin_shufflevector(v.x, v.y, 0, 8, 2, 10, 4, 12, 6, 14);
    const Lane odd_xy = __builtin_shufflevector(v.x, v.y, 1, 9, 3, 11, 5, 13, 7, 15);
    const Lane even_sw = __builtin_shufflevector(v.s, v.w, 0, 8, 2, 10, 4, 12, 6, 14);
    const Lane odd_sw = __builtin_shufflevector(v.s, v.w, 1, 9, 3, 11, 5, 13, 7, 15);
    put(u, i[0], i[2], __builtin_shufflevector(even_xy, even_sw, 0, 1, 8, 9, 2, 3, 10, 11));
    put(u, i[1], i[3], __builtin_shufflevector(odd_xy, odd_sw, 0, 1, 8, 9, 2, 3, 10, 11));
    put(u, i[4], i[6], __builtin_shufflevector(even_xy, even_sw, 4, 5, 12, 13, 6, 7, 14, 15));
    put(u, i[5], i[7], __builtin_shufflevector(odd_xy, odd_sw, 4, 5, 12, 13, 6, 7, 14, 15));
}
#elif defined(__AVX2__)
// By halves of bodies: an insert from memory is no shuffle, nor is a store of an upper half.
NAPPE_INLINE Lane halves(const double* p, const double* q) {
    return (Lane)_mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_load_pd(p)), _mm_load_pd(q), 1);
}

NAPPE_INLINE void put(double* p, double* q, const Lane& v) {
    _mm_store_pd(p, _mm256_castpd256_pd128((__m256d)v));
    _mm_store_pd(q, _mm256_extractf128_pd((__m256d)v, 1));
}

NAPPE_INLINE Bodies gather(const double* u, const std::uint32_t* i) {
    const double *a = u + i[0], *b = u + i[1], *c = u + i[2], *d = u + i[3];
    const Lane ac_xy = halves(a, c), bd_xy = halves(b, d), ac_sw = halves(a + 2, c + 2), bd_sw = halves(b + 2, d + 2);
    return {__builtin_shufflevector(ac_xy, bd_xy, 0, 4, 2, 6), __builtin_shufflevector(ac_xy, bd_xy, 1, 5, 3, 7),
            __builtin_shufflevector(ac_sw, bd_sw, 0, 4, 2, 6), __builtin_shufflevector(ac_sw, bd_sw, 1, 5, 3, 7)};
}

NAPPE_INLINE void scatter(double* u, const std::uint32_t* i, const Bodies& v) {
    put(u + i[0], u + i[2], __builtin_shufflevector(v.x, v.y, 0, 4, 2, 6));
    put(u + i[1], u + i[3], __builtin_shufflevector(v.x, v.y, 1, 5, 3, 7));
    put(u + i[0] + 2, u + i[2] + 2, __builtin_shufflevector(v.s, v.w, 0, 4, 2, 6));
    put(u + i[1] + 2, u + i[3] + 2, __builtin_shufflevector(v.s, v.w, 1, 5, 3, 7));
}
#elif defined(NAPPE_SCALAR)
NAPPE_INLINE Bodies gather(const double* u, const std::uint32_t* i) {
    const double* a = u + i[0];
    return {load(a), load(a + 1), load(a + 2), load(a + 3)};
}

NAPPE_INLINE void scatter(double* u, const std::uint32_t* i, const Bodies& v) {
    double* a = u + i[0];
    store(a, v.x);
    store(a + 1, v.y);
    store(a + 2, v.s);
}
#else
NAPPE_INLINE Bodies gather(const double* u, const std::uint32_t* i) {
    const double *a = u + i[0], *b = u + i[1];
    const Lane a_v = load(a), b_v = load(b), a_s = load(a + 2), b_s = load(b + 2);
    return {__builtin_shufflevector(a_v, b_v, 0, 2), __builtin_shufflevector(a_v, b_v, 1, 3),
            __builtin_shufflevector(a_s, b_s, 0, 2), __builtin_shufflevector(a_s, b_s, 1, 3)};
}

NAPPE_INLINE void scatter(double* u, const std::uint32_t* i, const Bodies& v) {
    double *a = u + i[0], *b = u + i[1];
    store(a, __builtin_shufflevector(v.x, v.y, 0, 2));
    store(b, __builtin_shufflevector(v.x, v.y, 1, 3));
    store(a + 2, __builtin_shufflevector(v.s, v.w, 0, 2));
    store(b + 2, __builtin_shufflevector(v.s, v.w, 1, 3));
}
#endif

/// The impulse d_n acts on both bodies of each lane.
NAPPE_INLINE void push(Bodies& a, Bodies& b, const Lane& nx, const Lane& ny, const Lane& d_n) {
    const Lane px = d_n * nx;
    const Lane py = d_n * ny;
    a.x += px * a.w;
    a.y += py * a.w;
    b.x -= px * b.w;
    b.y -= py * b.w;
}

/// The impulses d_n, d_t do.
NAPPE_INLINE void push(Bodies& a, Bodies& b, const Lane& nx, const Lane& ny, const Lane& d_n, const Lane& d_t) {
    const Lane px = d_n * nx - d_t * ny;
    const Lane py = d_n * ny + d_t * nx;
    const Lane spin = d_t + d_t;
    a.x += px * a.w;
    a.y += py * a.w;
    a.s -= spin * a.w;
    b.x -= px * b.w;
    b.y -= py * b.w;
    b.s -= spin * b.w;
}

} // namespace
} // namespace nappe
