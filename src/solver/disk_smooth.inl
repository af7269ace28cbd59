// Cundall's contacts (seeds/004, annex), one source for all instruction sets as disk_sweep.inl, whose signs these are: n
// points from b to a, v_n > 0 opens, t = (-n_y, n_x), and forces act on a. Where the disks overlap (eq. 3), with d the
// overlap, and velocities of half a step ago (eq. 25, 26):
//     f_n = k_n d - c_n v_n                                       (9), (11): d for the sum of v_n dt
//     s  <- clamp(s - k_s v_t h, -mu |f_n|, mu |f_n|)             the spring, (10), (12), (13)
//     f_t = clamp(s - c_s v_t, -mu |f_n|, mu |f_n|)               (13)
// Elsewhere all are 0. f_n may pull: the dashpot does until the overlap has ended.

#define NAPPE_INLINE inline __attribute__((always_inline))

namespace nappe {
namespace {

NAPPE_INLINE Lane clamped(const Lane& wanted, const Lane& limit) {
    const Lane above = wanted > limit ? limit : wanted;
    return above < -limit ? -limit : above;
}

template <bool tangential>
NAPPE_INLINE void press_all(const BatchSpan& batches, const SpringBatch* springs, const double* u_old, double* u,
                            double h) {
    const Lane zero = {}, one = zero + 1;
    for (std::int64_t k = 0; k < batches.n; ++k) {
        DiskBatch& batch = batches.contacts[k];
        const SpringBatch& spring = springs[k];
        for (int l = 0; l < n_lanes; l += width) {
            const Bodies a_old = gather(u_old, batch.a + l), b_old = gather(u_old, batch.b + l);
            const Lane nx = load(batch.nx + l), ny = load(batch.ny + l);
            const Lane gap = load(batches.kept_gaps[k].gap + l);
            const Lane touching = load(batch.m_eff + l) > zero ? (gap < zero ? one : zero) : zero;
            const Lane dvx = a_old.x - b_old.x, dvy = a_old.y - b_old.y;
            const Lane v_n = nx * dvx + ny * dvy;
            const Lane pressed = (zero - gap) * load(spring.k_n + l) - load(spring.c_n + l) * v_n;
            const Lane r_n = touching > zero ? h * pressed : zero;
            store(batch.r_n + l, r_n);
            Bodies a = gather(u, batch.a + l), b = gather(u, batch.b + l);
            if constexpr (tangential) {
                const Lane v_t = (nx * dvy - ny * dvx) - (a_old.s + b_old.s);
                const Lane limit = load(spring.mu + l) * (r_n < zero ? zero - r_n : r_n);
                const Lane stretched = load(batches.tangent[k].r_t + l) - (h * h) * (load(spring.k_s + l) * v_t);
                const Lane s = touching > zero ? clamped(stretched, limit) : zero;
                const Lane r_t = touching > zero ? clamped(s - h * (load(spring.c_s + l) * v_t), limit) : zero;
                store(batches.tangent[k].r_t + l, s);
                store(batches.summed[k].t + l, r_t - s);
                push(a, b, nx, ny, r_n, r_t);
            } else {
                push(a, b, nx, ny, r_n);
            }
            scatter(u, batch.a + l, a);
            scatter(u, batch.b + l, b);
        }
    }
}

void press(const BatchSpan& batches, const SpringBatch* springs, const double* u_old, double* u, double h) {
    if (batches.tangent == nullptr) {
        press_all<false>(batches, springs, u_old, u, h);
    } else {
        press_all<true>(batches, springs, u_old, u, h);
    }
}

} // namespace
} // namespace nappe

#undef NAPPE_INLINE
