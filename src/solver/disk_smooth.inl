// Cundall's contacts (seeds/004, annex), one source for all instruction sets as disk_sweep.inl, whose signs these are: n
// points from b to a, v_n > 0 opens, t = (-n_y, n_x), and forces act on a. Where the disks overlap (eq. 3), with d the
// overlap, and velocities of half a step ago (eq. 25, 26):
//     f_n = k_n d - c_n v_n                                       (9), (11): d for the sum of v_n dt
//     s  <- clamp(s - k_s v_t h, -mu |f_n|, mu |f_n|)             the spring, (10), (12), (13)
//     f_t = clamp(s - c_s v_t, -mu |f_n|, mu |f_n|)               (13)
// Elsewhere all are 0. f_n may pull: the dashpot does until the overlap has ended.
//
// Gap, normal, force and history of a contact are found in one pass, and of all that only the spring is stored: whoever
// asks for the rest after a step gets it from `record`, to the bit, since bodies keep where they were and how fast.

#define NAPPE_INLINE inline __attribute__((always_inline))

namespace nappe {
namespace {

NAPPE_INLINE Lane clamped(const Lane& wanted, const Lane& limit) {
    const Lane above = wanted > limit ? limit : wanted;
    return above < -limit ? -limit : above;
}

// add_rows: bodies i[0] … i[width-1] get x, y and s, in memory: half the shuffles of gather and scatter.
#if defined(__AVX512F__)
NAPPE_INLINE void add_rows(double* u, const std::uint32_t* i, const Lane& x, const Lane& y, const Lane& s) {
    const Lane zero = {};
    const Lane even_xy = __builtin_shufflevector(x, y, 0, 8, 2, 10, 4, 12, 6, 14);
    const Lane odd_xy = __builtin_shufflevector(x, y, 1, 9, 3, 11, 5, 13, 7, 15);
    const Lane even_s = __builtin_shufflevector(s, zero, 0, 8, 2, 10, 4, 12, 6, 14);
    const Lane odd_s = __builtin_shufflevector(s, zero, 1, 9, 3, 11, 5, 13, 7, 15);
    put(u, i[0], i[2], pair(u, i[0], i[2]) + __builtin_shufflevector(even_xy, even_s, 0, 1, 8, 9, 2, 3, 10, 11));
    put(u, i[1], i[3], pair(u, i[1], i[3]) + __builtin_shufflevector(odd_xy, odd_s, 0, 1, 8, 9, 2, 3, 10, 11));
    put(u, i[4], i[6], pair(u, i[4], i[6]) + __builtin_shufflevector(even_xy, even_s, 4, 5, 12, 13, 6, 7, 14, 15));
    put(u, i[5], i[7], pair(u, i[5], i[7]) + __builtin_shufflevector(odd_xy, odd_s, 4, 5, 12, 13, 6, 7, 14, 15));
}
#elif defined(__AVX2__)
NAPPE_INLINE void add_rows(double* u, const std::uint32_t* i, const Lane& x, const Lane& y, const Lane& s) {
    const Lane zero = {};
    double *a = u + i[0], *b = u + i[1], *c = u + i[2], *d = u + i[3];
    put(a, c, halves(a, c) + __builtin_shufflevector(x, y, 0, 4, 2, 6));
    put(b, d, halves(b, d) + __builtin_shufflevector(x, y, 1, 5, 3, 7));
    put(a + 2, c + 2, halves(a + 2, c + 2) + __builtin_shufflevector(s, zero, 0, 4, 2, 6));
    put(b + 2, d + 2, halves(b + 2, d + 2) + __builtin_shufflevector(s, zero, 1, 5, 3, 7));
}
#else
NAPPE_INLINE void add_rows(double* u, const std::uint32_t* i, const Lane& x, const Lane& y, const Lane& s) {
    Bodies b = gather(u, i);
    b.x += x;
    b.y += y;
    b.s += s;
    scatter(u, i, b);
}
#endif

/// One register of contacts.
struct Touch {
    Lane nx, ny, gap, smaller;
    Lane dvx, dvy, spin; ///< relative velocity of the centres, sum of the rims'
    Lane inv_m_a, inv_m_b;
};

/// @param walls whether some lanes may be of walls: their gaps and normals are in the batch
template <bool walls>
NAPPE_INLINE Touch touch(const DiskBatch& batch, const KeptGapBatch& kept, int l, const SmoothBodies& bodies) {
    const Lane zero = {}, one = zero + 1;
    const Bodies p = gather(bodies.mid, batch.a + l), q = gather(bodies.mid, batch.b + l);
    const Bodies a = gather(bodies.u_old, batch.a + l), b = gather(bodies.u_old, batch.b + l);
    const Lane dx = p.x - q.x, dy = p.y - q.y;
    const Lane distance = root(dx * dx + dy * dy);
    const Lane over = one / (distance > zero ? distance : one); // padding stands upon itself
    const Lane size = p.s + q.s;
    Touch t;
    t.nx = dx * over;
    t.ny = dy * over;
    t.gap = distance - size;
    t.smaller = q.s < p.s ? q.s : p.s;
    if constexpr (walls) { // whose radius is NaN
        t.nx = size == size ? t.nx : load(batch.nx + l);
        t.ny = size == size ? t.ny : load(batch.ny + l);
        t.gap = size == size ? t.gap : load(kept.gap + l);
    }
    t.dvx = a.x - b.x;
    t.dvy = a.y - b.y;
    t.spin = a.s + b.s;
    t.inv_m_a = a.w;
    t.inv_m_b = b.w;
    return t;
}

/// What the law of a register's contacts is.
struct Law {
    Lane k_n, k_s, c_n, c_s, mu;
};

NAPPE_INLINE Lane all(double v) {
    const Lane zero = {};
    return zero + v;
}

template <bool uniform>
NAPPE_INLINE Law law_of(const SpringBatch* springs, std::int64_t k, int l) {
    const SpringBatch &of = springs[k], &first = springs[0];
    if constexpr (uniform) { // half of what a contact streams from memory
        const Lane c = load(of.c_n + l);
        return {all(first.k_n[0]), all(first.k_s[0]), c, c, all(first.mu[0])};
    }
    return {load(of.k_n + l), load(of.k_s + l), load(of.c_n + l), load(of.c_s + l), load(of.mu + l)};
}

/// h times the normal force.
NAPPE_INLINE Lane pressed_n(const Touch& t, const Law& law, double h) {
    const Lane zero = {};
    const Lane v_n = t.nx * t.dvx + t.ny * t.dvy;
    const Lane f_n = (zero - t.gap) * law.k_n - law.c_n * v_n;
    return t.gap < zero ? h * f_n : zero;
}

NAPPE_INLINE Lane slip(const Touch& t) {
    return (t.nx * t.dvy - t.ny * t.dvx) - t.spin;
}

NAPPE_INLINE Lane magnitude(const Lane& v) {
    const Lane zero = {};
    return v < zero ? zero - v : v;
}

struct Met {
    Lane touching, deeper;
};

/// Contacts l … of a batch.
template <bool tangential, bool uniform, bool walls>
NAPPE_INLINE Met press_some(const BatchSpan& batches, const SpringBatch* springs, TangentBatch* after, std::int64_t k,
                            int l, const SmoothStep& step) {
    const Lane zero = {}, one = zero + 1;
    DiskBatch& batch = batches.contacts[k];
    const Touch t = touch<walls>(batch, batches.kept_gaps[k], l, step.bodies);
    const Law law = law_of<uniform>(springs, k, l);
    const Lane r_n = pressed_n(t, law, step.h);
    Lane rest = zero, px = r_n * t.nx, py = r_n * t.ny, spin = zero;
    if constexpr (tangential) {
        const Lane v_t = slip(t);
        const Lane limit = law.mu * magnitude(r_n);
        const Lane stretched = load(batches.tangent[k].r_t + l) - (step.h * step.h) * (law.k_s * v_t);
        const Lane s = t.gap < zero ? clamped(stretched, limit) : zero;
        const Lane r_t = t.gap < zero ? clamped(s - step.h * (law.c_s * v_t), limit) : zero;
        store(after[k].r_t + l, s);
        px -= r_t * t.ny;
        py += r_t * t.nx;
        spin = zero - (r_t + r_t);
        rest = r_t - s;
    }
    if constexpr (walls) { // series ask for these in every step
        store(batch.r_n + l, r_n);
        store(batches.summed[k].t + l, rest);
    }
    add_rows(step.u, batch.a + l, px * t.inv_m_a, py * t.inv_m_a, spin * t.inv_m_a);
    px = zero - px;
    py = zero - py;
    add_rows(step.u, batch.b + l, px * t.inv_m_b, py * t.inv_m_b, spin * t.inv_m_b);
    return {t.gap < zero ? one : zero, (zero - t.gap) - step.share * t.smaller};
}

/// Asks for what the batches behind the k-th will need.
template <bool tangential, bool uniform>
NAPPE_INLINE void fetch_smooth(const BatchSpan& batches, const SpringBatch* springs, TangentBatch* after,
                               std::int64_t k) {
    constexpr int ahead = 6; // batches
    __builtin_prefetch(batches.contacts[k + ahead].a);
    __builtin_prefetch(springs[k + ahead].c_n);
    if constexpr (tangential) {
        __builtin_prefetch(batches.tangent + k + ahead);
        __builtin_prefetch(after + k + ahead, 1);
    }
    if constexpr (!uniform) {
        __builtin_prefetch(springs[k + ahead].k_n);
        __builtin_prefetch(springs[k + ahead].k_s);
        __builtin_prefetch(springs[k + ahead].c_s);
        __builtin_prefetch(springs[k + ahead].mu);
    }
}

template <bool tangential, bool uniform>
NAPPE_INLINE SmoothTally press_all(const BatchSpan& batches, const SpringBatch* springs, TangentBatch* after,
                                   const unsigned char* of_walls, const SmoothStep& step) {
    Lane touching = {}, deepest = {};
    for (std::int64_t k = 0; k < batches.n; ++k) {
        fetch_smooth<tangential, uniform>(batches, springs, after, k);
        for (int l = 0; l < n_lanes; l += width) {
            const Met met = of_walls != nullptr && of_walls[k] != 0
                                ? press_some<tangential, uniform, true>(batches, springs, after, k, l, step)
                                : press_some<tangential, uniform, false>(batches, springs, after, k, l, step);
            touching += met.touching;
            deepest = met.deeper > deepest ? met.deeper : deepest;
        }
    }
    return {sum_of(touching), largest_of(deepest)};
}

SmoothTally press(const BatchSpan& batches, const SpringBatch* springs, TangentBatch* after,
                  const unsigned char* of_walls, const SmoothStep& step) {
    if (batches.tangent == nullptr) {
        return press_all<false, false>(batches, springs, after, of_walls, step);
    }
    return step.uniform ? press_all<true, true>(batches, springs, after, of_walls, step)
                        : press_all<true, false>(batches, springs, after, of_walls, step);
}

/// @returns the largest overlap over the smaller radius
double record(const BatchSpan& batches, const SpringBatch* springs, const SmoothBodies& bodies, double h) {
    const Lane zero = {};
    Lane deepest = {};
    for (std::int64_t k = 0; k < batches.n; ++k) {
        DiskBatch& batch = batches.contacts[k];
        for (int l = 0; l < n_lanes; l += width) {
            const Touch t = touch<true>(batch, batches.kept_gaps[k], l, bodies);
            const Law law = law_of<false>(springs, k, l);
            const Lane r_n = pressed_n(t, law, h);
            store(batch.nx + l, t.nx);
            store(batch.ny + l, t.ny);
            store(batch.r_n + l, r_n);
            store(batches.kept_gaps[k].gap + l, t.gap);
            if (batches.tangent != nullptr) {
                const Lane s = load(batches.tangent[k].r_t + l), limit = law.mu * magnitude(r_n);
                const Lane damped = s - h * (law.c_s * slip(t));
                const Lane r_t = t.gap < zero ? clamped(damped, limit) : zero;
                store(batches.summed[k].t + l, r_t - s);
            }
            const Lane overlap = (zero - t.gap) / t.smaller; // NaN for padding
            deepest = overlap > deepest ? overlap : deepest;
        }
    }
    return largest_of(deepest);
}

typedef double FourDoubles __attribute__((vector_size(32), may_alias)); // a body, whatever the registers

NAPPE_INLINE FourDoubles four(const double* p) {
    return *reinterpret_cast<const FourDoubles*>(p);
}

void open_grains(const GrainArrays& grains, std::int64_t begin, std::int64_t end, const double* gained) {
    const FourDoubles gain = {gained[0], gained[1], 0, 0};
    constexpr std::int64_t ahead = 16; // rows: a tile is too short for the processor to see where this goes
    for (std::int64_t i = begin; i < end; ++i) {
        if (i % 2 == 0) { // two rows a line
            __builtin_prefetch(grains.u + 4 * (i + ahead), 1);
            __builtin_prefetch(grains.u_old + 4 * (i + ahead), 1);
            __builtin_prefetch(grains.mid + 4 * (i + ahead), 1);
            __builtin_prefetch(grains.x + 2 * (i + ahead), 1);
            __builtin_prefetch(grains.damping + 2 * (i + ahead));
        }
        const FourDoubles u = four(grains.u + 4 * i);
        const double a = grains.damping[2 * i], of_spin = grains.damping[2 * i + 1];
        const FourDoubles damping = {a, a, of_spin, 0};
        *reinterpret_cast<FourDoubles*>(grains.u_old + 4 * i) = u;
        *reinterpret_cast<FourDoubles*>(grains.u + 4 * i) = (u + gain) - damping * u;
        grains.mid[4 * i] = grains.x[2 * i];
        grains.mid[4 * i + 1] = grains.x[2 * i + 1];
        if (grains.rotation != nullptr) {
            grains.mid[4 * i + 3] = grains.rotation[i];
        }
    }
}

NAPPE_INLINE void close_one(const GrainArrays& grains, std::int64_t i, double h, GrainMotion& met) {
    const double a = grains.damping[2 * i], of_spin = grains.damping[2 * i + 1];
    const double share = 1 / (1 + a), share_of_spin = 1 / (1 + of_spin);
    double* const u = grains.u + 4 * i;
    u[0] *= share;
    u[1] *= share;
    u[2] *= share_of_spin;
    grains.x[2 * i] += h * u[0];
    grains.x[2 * i + 1] += h * u[1];
    if (grains.rotation != nullptr) {
        grains.rotation[i] += h * u[2] / grains.mid[4 * i + 2];
    }
    const double v2 = u[0] * u[0] + u[1] * u[1];
    const double m = 1 / u[3];
    met.fastest_squared = v2 > met.fastest_squared ? v2 : met.fastest_squared;
    met.zeros += (v2 + u[2]) * 0;
    met.kinetic += 0.5 * m * (v2 + 0.5 * (u[2] * u[2])); // I = m r²/2
    met.momentum[0] += m * u[0];
    met.momentum[1] += m * u[1];
}

#if defined(NAPPE_SCALAR)
NAPPE_INLINE std::int64_t close_some(const GrainArrays&, std::int64_t begin, std::int64_t, double, GrainMotion&) {
    return begin;
}
#else
typedef double LooseLane __attribute__((vector_size(8 * width), may_alias, aligned(8))); // wherever it stands

NAPPE_INLINE Lane load_loose(const double* p) {
    return (Lane) * reinterpret_cast<const LooseLane*>(p);
}

NAPPE_INLINE void store_loose(double* p, const Lane& v) {
    *reinterpret_cast<LooseLane*>(p) = (LooseLane)v;
}

// Of `width` rows of two doubles: the first ones, the second ones, and both in turn again.
#if defined(__AVX512F__)
#define NAPPE_FIRST(p, q) __builtin_shufflevector(p, q, 0, 2, 4, 6, 8, 10, 12, 14)
#define NAPPE_SECOND(p, q) __builtin_shufflevector(p, q, 1, 3, 5, 7, 9, 11, 13, 15)
#define NAPPE_LOW(x, y) __builtin_shufflevector(x, y, 0, 8, 1, 9, 2, 10, 3, 11)
#define NAPPE_HIGH(x, y) __builtin_shufflevector(x, y, 4, 12, 5, 13, 6, 14, 7, 15)
constexpr std::uint32_t rows_in_turn[width] = {0, 4, 8, 12, 16, 20, 24, 28};
#elif defined(__AVX2__)
#define NAPPE_FIRST(p, q) __builtin_shufflevector(p, q, 0, 2, 4, 6)
#define NAPPE_SECOND(p, q) __builtin_shufflevector(p, q, 1, 3, 5, 7)
#define NAPPE_LOW(x, y) __builtin_shufflevector(x, y, 0, 4, 1, 5)
#define NAPPE_HIGH(x, y) __builtin_shufflevector(x, y, 2, 6, 3, 7)
constexpr std::uint32_t rows_in_turn[width] = {0, 4, 8, 12};
#else
#define NAPPE_FIRST(p, q) __builtin_shufflevector(p, q, 0, 2)
#define NAPPE_SECOND(p, q) __builtin_shufflevector(p, q, 1, 3)
#define NAPPE_LOW(x, y) __builtin_shufflevector(x, y, 0, 2)
#define NAPPE_HIGH(x, y) __builtin_shufflevector(x, y, 1, 3)
constexpr std::uint32_t rows_in_turn[width] = {0, 4};
#endif

/// A register's rows at a time, from `begin` on. @returns the first row that is left
NAPPE_INLINE std::int64_t close_some(const GrainArrays& grains, std::int64_t begin, std::int64_t end, double h,
                                     GrainMotion& met) {
    const Lane zero = {}, one = zero + 1;
    Lane fastest = {}, zeros = {}, kinetic = {}, px = {}, py = {};
    std::int64_t i = begin;
    for (; i + width <= end; i += width) {
        const Lane d = load_loose(grains.damping + 2 * i), e = load_loose(grains.damping + 2 * i + width);
        const Lane share = one / (one + NAPPE_FIRST(d, e)), share_of_spin = one / (one + NAPPE_SECOND(d, e));
        Bodies u = gather(grains.u + 4 * i, rows_in_turn);
        u.x *= share;
        u.y *= share;
        u.s *= share_of_spin;
        scatter(grains.u + 4 * i, rows_in_turn, u);
        double* const at = grains.x + 2 * i;
        const Lane p = load_loose(at), q = load_loose(at + width);
        const Lane x = NAPPE_FIRST(p, q) + h * u.x, y = NAPPE_SECOND(p, q) + h * u.y;
        store_loose(at, NAPPE_LOW(x, y));
        store_loose(at + width, NAPPE_HIGH(x, y));
        if (grains.rotation != nullptr) {
            const Lane radius = gather(grains.mid + 4 * i, rows_in_turn).s;
            store_loose(grains.rotation + i, load_loose(grains.rotation + i) + h * u.s / radius);
        }
        const Lane v2 = u.x * u.x + u.y * u.y;
        fastest = v2 > fastest ? v2 : fastest;
        zeros += (v2 + u.s) * zero;
        const Lane m = one / u.w;
        kinetic += 0.5 * m * (v2 + 0.5 * (u.s * u.s));
        px += m * u.x;
        py += m * u.y;
    }
    met = {largest_of(fastest), sum_of(zeros), sum_of(kinetic), {sum_of(px), sum_of(py)}};
    return i;
}

#undef NAPPE_FIRST
#undef NAPPE_SECOND
#undef NAPPE_LOW
#undef NAPPE_HIGH
#endif

GrainMotion close_grains(const GrainArrays& grains, std::int64_t begin, std::int64_t end, double h) {
    GrainMotion met;
    for (auto i = close_some(grains, begin, end, h, met); i < end; ++i) {
        close_one(grains, i, h, met);
    }
    return met;
}

} // namespace
} // namespace nappe

#undef NAPPE_INLINE
