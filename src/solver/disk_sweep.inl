// The inner contact loop, one source for all instruction sets: included by disk_sweep_*.cpp, each compiled with its own
// flags. Everything here is in an unnamed namespace and uses no library code, so that no copy of a function compiled
// for AVX-512 can be taken by the linker for the rest of the program.
//
// Signorini–Coulomb on impulses, one contact (seeds/000 eq. 5, 6 and the bias of docs/notation.md):
//     r_n <- max(0, r_n - (v_n + b) / W_nn),   r_t <- clamp(r_t - v_t / W_tt, -mu r_n, mu r_n)
// with W_nn = 1/m_a + 1/m_b and, for disks (I = m r²/2), W_tt = 3 W_nn, W_nt = 0. With s = r x spin the relative
// velocity is
//     v_n = n·(v_a - v_b),   v_t = t·(v_a - v_b) - (s_a + s_b),   t = (-n_y, n_x).
// With cohesion (the non-smooth Lennard-Jones law, seeds/000 §4.3) R = r_n + c, c = gamma h where the pair is bonded and
// 0 elsewhere, takes the place of r_n in both: r_n <- max(-c, …), |r_t| <= mu (r_n + c).
// An impulse changes v by ±(r_n n + r_t t)/m and s by -2 r_t/m on both sides.
// Selections are written `a > b ? a : b`, alike in scalar and vector code.

#include "solver/disk_lanes.inl"

namespace nappe {
namespace {

enum class Friction { none, uniform, mixed };

struct Impulses {
    Lane n, t;
};

/// P: the impulses nearest to the wanted ones that the law of lanes l … of batch k allows. `zero` is one.
template <Friction friction, bool cohesive>
NAPPE_INLINE Impulses feasible(const BatchSpan& batches, std::int64_t k, int l, const Lane& wanted_n,
                               const Lane& wanted_t, const Lane& zero) {
    // zero - 0 is +0, as the plain law has it: with gamma = 0 both give the same bits.
    const Lane most = cohesive ? load(batches.cohesion[k].most + l) : zero;
    const Lane least = cohesive ? zero - most : zero;
    Impulses r;
    r.n = wanted_n > least ? wanted_n : least;
    if constexpr (friction == Friction::none) {
        r.t = zero;
    } else {
        const Lane pressed = cohesive ? r.n + most : r.n;
        const Lane limit =
            friction == Friction::mixed ? load(batches.friction[k].mu + l) * pressed : batches.mu * pressed;
        const Lane above = wanted_t > limit ? limit : wanted_t;
        r.t = above < -limit ? -limit : above;
    }
    return r;
}

/// Asks for batches behind the k-th and for the bodies of the next tile. @param tangent whether there is friction
NAPPE_INLINE void fetch(const BatchSpan& batches, std::int64_t k, bool tangent, const double* u, BodyRange& soon) {
    constexpr int doubles_per_line = 8, lines_per_batch = 3; // of a cache; own bodies of a tile are two a batch
    constexpr int batches_ahead = 8;                         // about 200 ns: what memory takes
    for (std::size_t line = 0; line < sizeof(DiskBatch) / 64; ++line) {
        __builtin_prefetch(reinterpret_cast<const char*>(batches.contacts + k + batches_ahead) + 64 * line, 1);
    }
    if (tangent) {
        __builtin_prefetch(batches.tangent + k + batches_ahead, 1);
    }
    for (int line = 0; line < lines_per_batch && soon.begin < soon.end; ++line) {
        __builtin_prefetch(u + soon.begin, 1);
        soon.begin += doubles_per_line;
    }
}

#if defined(NAPPE_SCALAR)
NAPPE_INLINE double largest_of(Lane v) {
    return v;
}
#else
NAPPE_INLINE double largest_of(const Lane& v) {
    double largest = v[0];
    for (int k = 1; k < width; ++k) {
        largest = v[k] > largest ? v[k] : largest;
    }
    return largest;
}
#endif

/// @returns if watched, the largest (W (r - r_before))², else 0.
template <Friction friction, bool cohesive, bool watched>
NAPPE_INLINE double relax_all(const BatchSpan& batches, double* u, BodyRange soon) {
    Lane zero = {}, largest = {};
#if defined(__x86_64__)
    asm("" : "+x"(zero)); // not a literal, so that the selection below is one instruction, a maximum
#endif
    const double third = 1.0 / 3.0;
    DiskBatch* const contacts = batches.contacts;
    TangentBatch* const tangent = batches.tangent;
    for (std::int64_t k = 0; k < batches.n; ++k) {
        DiskBatch& batch = contacts[k];
        fetch(batches, k, friction != Friction::none, u, soon);
        for (int l = 0; l < n_lanes; l += width) {
            Bodies a = gather(u, batch.a + l);
            Bodies b = gather(u, batch.b + l);
            const Lane nx = load(batch.nx + l), ny = load(batch.ny + l), m = load(batch.m_eff + l);
            const Lane r_n = load(batch.r_n + l);
            const Lane dvx = a.x - b.x, dvy = a.y - b.y;
            const Lane v_n = nx * dvx + ny * dvy;
            const Lane wanted_n = r_n - (v_n + load(batch.bias + l)) * m;
            Lane squared = zero; // change of r_n / W_nn and r_t / W_tt, W_tt = 3 W_nn
            if constexpr (friction == Friction::none) {
                const Impulses r = feasible<friction, cohesive>(batches, k, l, wanted_n, zero, zero);
                store(batch.r_n + l, r.n);
                push(a, b, nx, ny, r.n - r_n);
                if constexpr (watched) {
                    squared = (r.n - r_n) * (r.n - r_n);
                }
            } else {
                const Lane r_t = load(tangent[k].r_t + l);
                const Lane v_t = (nx * dvy - ny * dvx) - (a.s + b.s);
                const Impulses r = feasible<friction, cohesive>(batches, k, l, wanted_n, r_t - v_t * (m * third), zero);
                store(batch.r_n + l, r.n);
                store(tangent[k].r_t + l, r.t);
                push(a, b, nx, ny, r.n - r_n, r.t - r_t);
                if constexpr (watched) {
                    squared = (r.n - r_n) * (r.n - r_n) + 9 * ((r.t - r_t) * (r.t - r_t));
                }
            }
            if constexpr (watched) {
                const Lane w = a.w + b.w;
                const Lane change = (w * w) * squared;
                largest = change > largest ? change : largest;
            }
            scatter(u, batch.a + l, a);
            scatter(u, batch.b + l, b);
        }
    }
    return watched ? largest_of(largest) : 0.0;
}

template <bool cohesive, class Pass>
NAPPE_INLINE auto by_friction(const BatchSpan& batches, const Pass& pass) {
    if (batches.tangent == nullptr) {
        return pass.template operator()<Friction::none, cohesive>();
    }
    if (batches.friction == nullptr) {
        return pass.template operator()<Friction::uniform, cohesive>();
    }
    return pass.template operator()<Friction::mixed, cohesive>();
}

/// The pass made for the laws that these batches have.
template <class Pass>
NAPPE_INLINE auto by_law(const BatchSpan& batches, const Pass& pass) {
    return batches.cohesion == nullptr ? by_friction<false>(batches, pass) : by_friction<true>(batches, pass);
}

void relax(const BatchSpan& batches, double* u, BodyRange soon) {
    by_law(batches,
           [&]<Friction friction, bool cohesive>() { relax_all<friction, cohesive, false>(batches, u, soon); });
}

double relax_watched(const BatchSpan& batches, double* u, BodyRange soon) {
    return by_law(batches, [&]<Friction friction, bool cohesive>() {
        return relax_all<friction, cohesive, true>(batches, u, soon);
    });
}

void apply(const BatchSpan& batches, double* u) {
    for (std::int64_t k = 0; k < batches.n; ++k) {
        const DiskBatch& batch = batches.contacts[k];
        for (int l = 0; l < n_lanes; l += width) {
            Bodies a = gather(u, batch.a + l);
            Bodies b = gather(u, batch.b + l);
            const Lane nx = load(batch.nx + l), ny = load(batch.ny + l), r_n = load(batch.r_n + l);
            if (batches.tangent == nullptr) {
                push(a, b, nx, ny, r_n);
            } else {
                push(a, b, nx, ny, r_n, load(batches.tangent[k].r_t + l));
            }
            scatter(u, batch.a + l, a);
            scatter(u, batch.b + l, b);
        }
    }
}

/// One register of a GapBatch.
struct Gaps {
    Lane nx, ny, gap, size, smaller, v, v_old, inv_m;
};

NAPPE_INLINE Gaps measure(const BodyArrays& bodies, const std::uint32_t* i, const std::uint32_t* j) {
    const Bodies p = gather(bodies.mid, i), q = gather(bodies.mid, j);
    const Lane dx = p.x - q.x, dy = p.y - q.y;
    const Lane distance = root(dx * dx + dy * dy);
    Gaps g;
    g.nx = dx / distance;
    g.ny = dy / distance;
    g.size = p.s + q.s;
    g.smaller = p.s < q.s ? p.s : q.s;
    g.gap = distance - g.size;
    const Bodies a = gather(bodies.u, i), b = gather(bodies.u, j);
    g.v = g.nx * (a.x - b.x) + g.ny * (a.y - b.y);
    g.inv_m = a.w + b.w;
    const Bodies a_old = gather(bodies.u_old, i), b_old = gather(bodies.u_old, j);
    g.v_old = g.nx * (a_old.x - b_old.x) + g.ny * (a_old.y - b_old.y);
    return g;
}

Refreshed refresh(const BatchSpan& batches, const BodyArrays& bodies, double h, double look) {
    const Lane zero = {}, one = zero + 1;
    Lane awake = {}, deepest = {};
    for (std::int64_t k = 0; k < batches.n; ++k) {
        DiskBatch& batch = batches.contacts[k];
        for (int l = 0; l < n_lanes; l += width) {
            const Gaps g = measure(bodies, batch.a + l, batch.b + l);
            // DiskContacts' rule of who sleeps; padding, without any mass that moves, always does.
            const Lane slower = g.v_old < g.v ? g.v_old : g.v;
            const Lane closes = slower < zero ? -2 * look * slower : zero;
            Lane acts = g.gap > 0.01 * g.size + closes ? zero : (g.inv_m > zero ? one : zero);
            if (batches.cohesion != nullptr) {
                acts = load(batches.cohesion[k].most + l) > zero ? one : acts;
            }
            store(batch.nx + l, g.inv_m > zero ? g.nx : zero);
            store(batch.ny + l, g.inv_m > zero ? g.ny : zero);
            store(batch.bias + l, g.gap > zero ? g.gap / h : zero);
            if (batches.kept_gaps != nullptr) {
                store(batches.kept_gaps[k].gap + l, g.inv_m > zero ? g.gap : zero);
            }
            store(batch.m_eff + l, acts > zero ? one / g.inv_m : zero);
            store(batch.r_n + l, acts > zero ? load(batch.r_n + l) : zero);
            if (batches.tangent != nullptr) {
                double* const r_t = batches.tangent[k].r_t + l;
                store(r_t, acts > zero ? load(r_t) : zero);
            }
            awake += acts;
            const Lane overlap = (zero - g.gap) / g.smaller; // NaN for walls and padding
            deepest = overlap > deepest ? overlap : deepest;
        }
    }
    return {static_cast<std::int64_t>(sum_of(awake)), largest_of(deepest)};
}

void gaps(const std::int32_t* which, std::int64_t n, const std::int32_t* a, const std::int32_t* b,
          const BodyArrays& bodies, GapBatch* out) {
    for (std::int64_t k = 0; k < n; k += n_lanes) {
        std::uint32_t i[n_lanes], j[n_lanes];
        for (int l = 0; l < n_lanes; ++l) {
            const std::int64_t at = k + l < n ? k + l : n - 1;
            const std::int64_t c = which != nullptr ? which[at] : at;
            i[l] = 4u * static_cast<std::uint32_t>(a[c]);
            j[l] = 4u * static_cast<std::uint32_t>(b[c]);
        }
        GapBatch& batch = out[k / n_lanes];
        for (int l = 0; l < n_lanes; l += width) {
            const Gaps g = measure(bodies, i + l, j + l);
            store(batch.nx + l, g.nx);
            store(batch.ny + l, g.ny);
            store(batch.gap + l, g.gap);
            store(batch.size + l, g.size);
            store(batch.v + l, g.v);
            store(batch.v_old + l, g.v_old);
        }
    }
}

} // namespace
} // namespace nappe
