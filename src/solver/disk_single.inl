// The sweep in single precision (SolverSettings::precision), one source for all instruction sets: included by
// disk_sweep_*.cpp after disk_methods.inl, whose rules hold here too. The law is that of disk_sweep.inl, number for
// number, in float; friction and cohesion are read where they are, in double, and rounded in a register. What was found
// goes back to double in `settle_single`.

namespace nappe {
namespace {

#define NAPPE_INLINE inline __attribute__((always_inline))

// Eight floats a register where there are 256 bits, else four: a batch takes 8 / float_width of them.
#if defined(NAPPE_SCALAR)
constexpr int float_width = 1;
typedef float FloatLane;
#else
#if defined(__AVX2__)
constexpr int float_width = 8;
#else
constexpr int float_width = 4;
#endif
typedef float FloatLane
    __attribute__((vector_size(4 * float_width), may_alias)); // one number of `float_width` contacts
#endif

/// v_x, v_y, s, 1/m of `float_width` bodies.
struct FloatBodies {
    FloatLane x, y, s, w;
};

NAPPE_INLINE FloatLane load(const float* p) {
    return *reinterpret_cast<const FloatLane*>(p);
}

NAPPE_INLINE void store(float* p, const FloatLane& v) {
    *reinterpret_cast<FloatLane*>(p) = v;
}

/// Doubles, rounded.
NAPPE_INLINE FloatLane rounded(const double* p) {
#if defined(NAPPE_SCALAR)
    return static_cast<float>(*p);
#else
    FloatLane v;
    for (int k = 0; k < float_width; ++k) {
        v[k] = static_cast<float>(p[k]);
    }
    return v;
#endif
}

#if defined(NAPPE_SCALAR)
NAPPE_INLINE FloatBodies gather(const float* u, const std::uint32_t* i) {
    const float* a = u + i[0];
    return {a[0], a[1], a[2], a[3]};
}

NAPPE_INLINE void scatter(float* u, const std::uint32_t* i, const FloatBodies& v) {
    float* a = u + i[0];
    a[0] = v.x;
    a[1] = v.y;
    a[2] = v.s;
}
#else
#if defined(__AVX2__)
/// Bodies i and j in the lower and upper half: an insert from memory is no shuffle, nor is a store of an upper half.
NAPPE_INLINE FloatLane pair(const float* u, std::uint32_t i, std::uint32_t j) {
    return (FloatLane)_mm256_insertf128_ps(_mm256_castps128_ps256(_mm_load_ps(u + i)), _mm_load_ps(u + j), 1);
}

NAPPE_INLINE void put(float* u, std::uint32_t i, std::uint32_t j, const FloatLane& v) {
    _mm_store_ps(u + i, _mm256_castps256_ps128((__m256)v));
    _mm_store_ps(u + j, _mm256_extractf128_ps((__m256)v, 1));
}

// Within halves of a register, so that no shuffle crosses them.
#define NAPPE_LOW(a, b) __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13)
#define NAPPE_HIGH(a, b) __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15)
#define NAPPE_FIRST(a, b) __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13)
#define NAPPE_SECOND(a, b) __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15)
#define NAPPE_GET(u, i, k) pair(u, i[k], i[k + 4])
#define NAPPE_PUT(u, i, k, v) put(u, i[k], i[k + 4], v)
#else
NAPPE_INLINE FloatLane row(const float* u, std::uint32_t i) {
    return *reinterpret_cast<const FloatLane*>(u + i);
}

NAPPE_INLINE void put(float* u, std::uint32_t i, const FloatLane& v) {
    *reinterpret_cast<FloatLane*>(u + i) = v;
}

#define NAPPE_LOW(a, b) __builtin_shufflevector(a, b, 0, 4, 1, 5)
#define NAPPE_HIGH(a, b) __builtin_shufflevector(a, b, 2, 6, 3, 7)
#define NAPPE_FIRST(a, b) __builtin_shufflevector(a, b, 0, 1, 4, 5)
#define NAPPE_SECOND(a, b) __builtin_shufflevector(a, b, 2, 3, 6, 7)
#define NAPPE_GET(u, i, k) row(u, i[k])
#define NAPPE_PUT(u, i, k, v) put(u, i[k], v)
#endif

NAPPE_INLINE FloatBodies gather(const float* u, const std::uint32_t* i) {
    const FloatLane a = NAPPE_GET(u, i, 0), b = NAPPE_GET(u, i, 1), c = NAPPE_GET(u, i, 2), d = NAPPE_GET(u, i, 3);
    const FloatLane ab_xy = NAPPE_LOW(a, b), ab_sw = NAPPE_HIGH(a, b);
    const FloatLane cd_xy = NAPPE_LOW(c, d), cd_sw = NAPPE_HIGH(c, d);
    return {NAPPE_FIRST(ab_xy, cd_xy), NAPPE_SECOND(ab_xy, cd_xy), NAPPE_FIRST(ab_sw, cd_sw),
            NAPPE_SECOND(ab_sw, cd_sw)};
}

NAPPE_INLINE void scatter(float* u, const std::uint32_t* i, const FloatBodies& v) {
    const FloatLane ab_xy = NAPPE_LOW(v.x, v.y), ab_sw = NAPPE_LOW(v.s, v.w);
    const FloatLane cd_xy = NAPPE_HIGH(v.x, v.y), cd_sw = NAPPE_HIGH(v.s, v.w);
    NAPPE_PUT(u, i, 0, NAPPE_FIRST(ab_xy, ab_sw));
    NAPPE_PUT(u, i, 1, NAPPE_SECOND(ab_xy, ab_sw));
    NAPPE_PUT(u, i, 2, NAPPE_FIRST(cd_xy, cd_sw));
    NAPPE_PUT(u, i, 3, NAPPE_SECOND(cd_xy, cd_sw));
}
#undef NAPPE_LOW
#undef NAPPE_HIGH
#undef NAPPE_FIRST
#undef NAPPE_SECOND
#undef NAPPE_GET
#undef NAPPE_PUT
#endif

template <Friction friction, bool cohesive>
NAPPE_INLINE void relax_all_single(const BatchSpan& batches, SingleBatch* contacts, float* u, BodyRange soon) {
    constexpr int floats_per_line = 16, lines_per_batch = 2, batches_ahead = 8; // of a cache, as in double
    FloatLane zero = {};
#if defined(__x86_64__)
    asm("" : "+x"(zero)); // not a literal, so that the selection below is one instruction, a maximum
#endif
    const float third = 1.0f / 3.0f;
    const float mu = static_cast<float>(batches.mu);
    for (std::int64_t k = 0; k < batches.n; ++k) {
        SingleBatch& batch = contacts[k];
        for (std::size_t line = 0; line < sizeof(SingleBatch) / 64; ++line) {
            __builtin_prefetch(reinterpret_cast<const char*>(contacts + k + batches_ahead) + 64 * line, 1);
        }
        for (int line = 0; line < lines_per_batch && soon.begin < soon.end; ++line) {
            __builtin_prefetch(u + soon.begin, 1);
            soon.begin += floats_per_line;
        }
        for (int l = 0; l < n_lanes; l += float_width) {
            FloatBodies a = gather(u, batch.a + l);
            FloatBodies b = gather(u, batch.b + l);
            const FloatLane nx = load(batch.nx + l), ny = load(batch.ny + l), m = load(batch.m_eff + l);
            const FloatLane r_n = load(batch.r_n + l);
            const FloatLane dvx = a.x - b.x, dvy = a.y - b.y;
            const FloatLane v_n = nx * dvx + ny * dvy;
            const FloatLane wanted_n = r_n - (v_n + load(batch.bias + l)) * m;
            const FloatLane most = cohesive ? rounded(batches.cohesion[k].most + l) : zero;
            const FloatLane least = cohesive ? zero - most : zero;
            const FloatLane new_n = wanted_n > least ? wanted_n : least;
            const FloatLane d_n = new_n - r_n;
            store(batch.r_n + l, new_n);
            FloatLane px = d_n * nx, py = d_n * ny;
            if constexpr (friction != Friction::none) {
                const FloatLane r_t = load(batch.r_t + l);
                const FloatLane v_t = (nx * dvy - ny * dvx) - (a.s + b.s);
                const FloatLane wanted_t = r_t - v_t * (m * third);
                const FloatLane pressed = cohesive ? new_n + most : new_n;
                const FloatLane limit =
                    friction == Friction::mixed ? rounded(batches.friction[k].mu + l) * pressed : mu * pressed;
                const FloatLane above = wanted_t > limit ? limit : wanted_t;
                const FloatLane new_t = above < -limit ? -limit : above;
                const FloatLane d_t = new_t - r_t;
                store(batch.r_t + l, new_t);
                px -= d_t * ny;
                py += d_t * nx;
                const FloatLane spin = d_t + d_t;
                a.s -= spin * a.w;
                b.s -= spin * b.w;
            }
            a.x += px * a.w;
            a.y += py * a.w;
            b.x -= px * b.w;
            b.y -= py * b.w;
            scatter(u, batch.a + l, a);
            scatter(u, batch.b + l, b);
        }
    }
}

void relax_single(const BatchSpan& batches, SingleBatch* contacts, float* u, BodyRange soon) {
    by_law(batches, [&]<Friction friction, bool cohesive>() {
        relax_all_single<friction, cohesive>(batches, contacts, u, soon);
    });
}

void round_batches(const BatchSpan& batches, SingleBatch* contacts) {
    for (std::int64_t k = 0; k < batches.n; ++k) {
        const DiskBatch& from = batches.contacts[k];
        SingleBatch& to = contacts[k];
        for (int l = 0; l < n_lanes; ++l) {
            to.nx[l] = static_cast<float>(from.nx[l]);
            to.ny[l] = static_cast<float>(from.ny[l]);
            to.bias[l] = static_cast<float>(from.bias[l]);
            to.m_eff[l] = static_cast<float>(from.m_eff[l]);
            to.r_n[l] = static_cast<float>(from.r_n[l]);
            to.r_t[l] = batches.tangent == nullptr ? 0.0f : static_cast<float>(batches.tangent[k].r_t[l]);
            to.a[l] = from.a[l];
            to.b[l] = from.b[l];
        }
    }
}

/// Projected once more, since a limit that is rounded may allow a little more than the law.
void settle_single(const BatchSpan& batches, const SingleBatch* contacts, double* u) {
    by_law(batches, [&]<Friction friction, bool cohesive>() {
        const Lane zero = {};
        for (std::int64_t k = 0; k < batches.n; ++k) {
            const DiskBatch& batch = batches.contacts[k];
            alignas(64) double n[n_lanes], t[n_lanes];
            for (int l = 0; l < n_lanes; ++l) {
                n[l] = contacts[k].r_n[l];
                t[l] = contacts[k].r_t[l];
            }
            for (int l = 0; l < n_lanes; l += width) {
                const Impulses r = load_impulses<friction>(batches, k, l);
                const Impulses z = feasible<friction, cohesive>(batches, k, l, load(n + l), load(t + l), zero);
                store_impulses<friction>(batches, k, l, z);
                push_and_scatter<friction>(batch, l, u, gather(u, batch.a + l), gather(u, batch.b + l),
                                           load(batch.nx + l), load(batch.ny + l), z - r);
            }
        }
    });
}

#undef NAPPE_INLINE

} // namespace
} // namespace nappe
