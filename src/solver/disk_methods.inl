// Passes of the methods that look back at earlier impulses (nncg.cpp, ansgs.cpp, apgd.cpp, cpg.cpp), one source for all
// instruction sets, with disk_sweep.inl, whose rules hold here too: included by disk_sweep_*.cpp. A contact's impulses are moved on where it
// is relaxed, so that a method costs one pass; velocities, which are linear in the impulses, were moved on before it.

#include "solver/disk_sweep.inl"

namespace nappe {
namespace {

/// One register of contacts with their bodies.
struct Gathered {
    Bodies a, b;
    Lane nx, ny, m, v_n, v_t;
};

NAPPE_INLINE Gathered gather_contacts(const DiskBatch& batch, int l, const double* u) {
    Gathered c{gather(u, batch.a + l),
               gather(u, batch.b + l),
               load(batch.nx + l),
               load(batch.ny + l),
               load(batch.m_eff + l),
               {},
               {}};
    const Lane dvx = c.a.x - c.b.x, dvy = c.a.y - c.b.y;
    c.v_n = c.nx * dvx + c.ny * dvy;
    c.v_t = (c.nx * dvy - c.ny * dvx) - (c.a.s + c.b.s);
    return c;
}

template <Friction friction>
NAPPE_INLINE Impulses load_impulses(const BatchSpan& batches, std::int64_t k, int l) {
    const Lane none = {};
    return {load(batches.contacts[k].r_n + l), friction == Friction::none ? none : load(batches.tangent[k].r_t + l)};
}

template <Friction friction>
NAPPE_INLINE void store_impulses(const BatchSpan& batches, std::int64_t k, int l, const Impulses& r) {
    store(batches.contacts[k].r_n + l, r.n);
    if constexpr (friction != Friction::none) {
        store(batches.tangent[k].r_t + l, r.t);
    }
}

NAPPE_INLINE Impulses load(const SearchBatch& batch, int l) {
    return {load(batch.n + l), load(batch.t + l)};
}

NAPPE_INLINE void store(SearchBatch& batch, int l, const Impulses& r) {
    store(batch.n + l, r.n);
    store(batch.t + l, r.t);
}

NAPPE_INLINE Impulses operator+(const Impulses& p, const Impulses& q) {
    return {p.n + q.n, p.t + q.t};
}

NAPPE_INLINE Impulses operator-(const Impulses& p, const Impulses& q) {
    return {p.n - q.n, p.t - q.t};
}

NAPPE_INLINE Impulses operator*(double f, const Impulses& p) {
    return {f * p.n, f * p.t};
}

/// Adds the effect of r on bodies that a batch's lanes have in `u`.
template <Friction friction>
NAPPE_INLINE void push_and_scatter(const DiskBatch& batch, int l, double* u, Bodies a, Bodies b, const Lane& nx,
                                   const Lane& ny, const Impulses& r) {
    if constexpr (friction == Friction::none) {
        push(a, b, nx, ny, r.n);
    } else {
        push(a, b, nx, ny, r.n, r.t);
    }
    scatter(u, batch.a + l, a);
    scatter(u, batch.b + l, b);
}

/// Adds up terms without any error (TermRounding).
class Sums {
public:
    explicit Sums(const TermRounding& rounding) : rounding_(rounding) {}

    NAPPE_INLINE Lane rounded(const Lane& term) const {
        const Lane zero = {}, most = zero + rounding_.most;
        const Lane below = term > most ? most : term;
        return ((below < -most ? -most : below) + rounding_.magic) - rounding_.magic;
    }

    /// W p q, W = w that of the normal direction.
    static NAPPE_INLINE Lane product(const Lane& w, const Impulses& p, const Impulses& q) {
        return w * (p.n * q.n + 3 * (p.t * q.t));
    }

    NAPPE_INLINE void add(const Lane& squared, const Lane& along) {
        squared_ += rounded(squared);
        along_ += rounded(along);
    }

    NAPPE_INLINE StepSums sums() const { return {sum_of(squared_), sum_of(along_)}; }

private:
    TermRounding rounding_;
    Lane squared_ = {}, along_ = {};
};

/// Gauss–Seidel on lanes l … of batch k, from y. @param w gets 1/m_a + 1/m_b
template <Friction friction, bool cohesive>
NAPPE_INLINE Impulses relax_from(const BatchSpan& batches, std::int64_t k, int l, const Impulses& y, double* u,
                                 Lane& w) {
    const Lane zero = {};
    const double third = 1.0 / 3.0;
    const DiskBatch& batch = batches.contacts[k];
    const Gathered c = gather_contacts(batch, l, u);
    const Impulses z = feasible<friction, cohesive>(batches, k, l, y.n - (c.v_n + load(batch.bias + l)) * c.m,
                                                    y.t - c.v_t * (c.m * third), zero);
    push_and_scatter<friction>(batch, l, u, c.a, c.b, c.nx, c.ny, z - y);
    w = c.a.w + c.b.w;
    return z;
}

void advance(const BatchSpan& batches, const double* u, double h) {
    const Lane zero = {};
    for (std::int64_t k = 0; k < batches.n; ++k) {
        DiskBatch& batch = batches.contacts[k];
        for (int l = 0; l < n_lanes; l += width) {
            const Bodies a = gather(u, batch.a + l), b = gather(u, batch.b + l);
            const Lane v_n = load(batch.nx + l) * (a.x - b.x) + load(batch.ny + l) * (a.y - b.y);
            const Lane gap = load(batches.kept_gaps[k].gap + l) + h * v_n;
            store(batches.kept_gaps[k].gap + l, gap);
            store(batch.bias + l, gap > zero ? gap / h : zero);
            if (batches.summed != nullptr) {
                SearchBatch& sum = batches.summed[k];
                store(sum.n + l, load(sum.n + l) + load(batch.r_n + l));
                store(sum.t + l, batches.tangent ? load(sum.t + l) + load(batches.tangent[k].r_t + l) : zero);
            }
        }
    }
}

void begin_correction(const BatchSpan& batches, DiskBatch* out, const double* u, double h, double share) {
    const Lane zero = {};
    for (std::int64_t k = 0; k < batches.n; ++k) {
        const DiskBatch& batch = batches.contacts[k];
        out[k] = batch;
        for (int l = 0; l < n_lanes; l += width) {
            const Bodies a = gather(u, batch.a + l), b = gather(u, batch.b + l);
            const Lane v_n = load(batch.nx + l) * (a.x - b.x) + load(batch.ny + l) * (a.y - b.y);
            const Lane gap = load(batches.kept_gaps[k].gap + l) + h * v_n;
            store(out[k].bias + l, (gap < zero ? share * gap : gap) / h);
            store(out[k].r_n + l, zero);
        }
    }
}

StepSums relax_ahead(const BatchSpan& batches, SearchBatch* before, double beta, const TermRounding& rounding,
                     double* u, BodyRange soon) {
    return by_law(batches, [&]<Friction friction, bool cohesive>() {
        Sums sums(rounding);
        for (std::int64_t k = 0; k < batches.n; ++k) {
            fetch(batches, k, friction != Friction::none, u, soon);
            for (int l = 0; l < n_lanes; l += width) {
                const Impulses x = load_impulses<friction>(batches, k, l);
                const Impulses y = x + beta * (x - load(before[k], l));
                Lane w;
                const Impulses z = relax_from<friction, cohesive>(batches, k, l, y, u, w);
                store(before[k], l, x);
                store_impulses<friction>(batches, k, l, z);
                sums.add(Sums::product(w, z - y, z - y), Sums::product(w, z - y, z - x));
            }
        }
        return sums.sums();
    });
}

StepSums relax_along(const BatchSpan& batches, SearchBatch* from, SearchBatch* direction, double beta,
                     const TermRounding& rounding, double* u, BodyRange soon) {
    return by_law(batches, [&]<Friction friction, bool cohesive>() {
        Sums sums(rounding);
        for (std::int64_t k = 0; k < batches.n; ++k) {
            fetch(batches, k, friction != Friction::none, u, soon);
            for (int l = 0; l < n_lanes; l += width) {
                const Impulses x = load_impulses<friction>(batches, k, l);
                const Impulses ahead = beta * load(direction[k], l);
                const Impulses y = x + ahead;
                store(direction[k], l, ahead + (x - load(from[k], l)));
                store(from[k], l, y);
                Lane w;
                const Impulses z = relax_from<friction, cohesive>(batches, k, l, y, u, w);
                store_impulses<friction>(batches, k, l, z);
                sums.add(Sums::product(w, z - y, z - y), Lane{});
            }
        }
        return sums.sums();
    });
}

StepSums project(const BatchSpan& batches, SearchBatch* before, double beta, double step, const TermRounding& rounding,
                 const double* at, double* u) {
    return by_law(batches, [&]<Friction friction, bool cohesive>() {
        const Lane zero = {};
        const double third = 1.0 / 3.0;
        Sums sums(rounding);
        for (std::int64_t k = 0; k < batches.n; ++k) {
            const DiskBatch& batch = batches.contacts[k];
            for (int l = 0; l < n_lanes; l += width) {
                const Impulses x = load_impulses<friction>(batches, k, l);
                const Impulses y = x + beta * (x - load(before[k], l));
                const Gathered c = gather_contacts(batch, l, at);
                const Lane m = step * c.m;
                const Impulses z = feasible<friction, cohesive>(batches, k, l, y.n - (c.v_n + load(batch.bias + l)) * m,
                                                                y.t - c.v_t * (m * third), zero);
                store(before[k], l, x);
                store_impulses<friction>(batches, k, l, z);
                push_and_scatter<friction>(batch, l, u, gather(u, batch.a + l), gather(u, batch.b + l), c.nx, c.ny,
                                           z - y);
                const Lane w = c.a.w + c.b.w;
                sums.add(Sums::product(w, z - y, z - y), Sums::product(w, z - y, z - x));
            }
        }
        return sums.sums();
    });
}

/// T: what is left of a direction where it would lead out of what the law allows: normal impulses at their least may not
/// sink, tangential ones at their bound not grow, and none changes where there is no pressure and none is coming.
template <Friction friction, bool cohesive>
NAPPE_INLINE Impulses open_part(const BatchSpan& batches, std::int64_t k, int l, const Impulses& r,
                                const Impulses& wanted) {
    const Lane zero = {};
    const Lane pressed = cohesive ? r.n + load(batches.cohesion[k].most + l) : r.n;
    Impulses open;
    open.n = pressed > zero ? wanted.n : (wanted.n > zero ? wanted.n : zero);
    if constexpr (friction == Friction::none) {
        open.t = zero;
    } else {
        const Lane limit =
            friction == Friction::mixed ? load(batches.friction[k].mu + l) * pressed : batches.mu * pressed;
        const Lane up = r.t < limit ? wanted.t : (wanted.t < zero ? wanted.t : zero);
        const Lane both = r.t > -limit ? up : (up > zero ? up : zero);
        open.t = pressed > zero ? both : (wanted.n > zero ? wanted.t : zero);
    }
    return open;
}

StepSums gradient(const BatchSpan& batches, SearchBatch* z, SearchBatch* p, const TermRounding& rounding,
                  const double* at, double* of_z) {
    return by_law(batches, [&]<Friction friction, bool cohesive>() {
        const double third = 1.0 / 3.0;
        Sums sums(rounding);
        for (std::int64_t k = 0; k < batches.n; ++k) {
            const DiskBatch& batch = batches.contacts[k];
            for (int l = 0; l < n_lanes; l += width) {
                const Impulses r = load_impulses<friction>(batches, k, l);
                const Gathered c = gather_contacts(batch, l, at);
                const Impulses down{-((c.v_n + load(batch.bias + l)) * c.m), -(c.v_t * (c.m * third))};
                const Impulses step = open_part<friction, cohesive>(batches, k, l, r, down);
                store(z[k], l, step);
                store(p[k], l, open_part<friction, cohesive>(batches, k, l, r, load(p[k], l)));
                push_and_scatter<friction>(batch, l, of_z, gather(of_z, batch.a + l), gather(of_z, batch.b + l), c.nx,
                                           c.ny, step);
                sums.add(Sums::product(c.a.w + c.b.w, down, step), Lane{});
            }
        }
        return sums.sums();
    });
}

StepSums turn(const BatchSpan& batches, const SearchBatch* z, SearchBatch* p, double beta, const TermRounding& rounding,
              const double* at, double* of_p) {
    return by_law(batches, [&]<Friction friction, bool>() {
        Sums sums(rounding);
        for (std::int64_t k = 0; k < batches.n; ++k) {
            const DiskBatch& batch = batches.contacts[k];
            for (int l = 0; l < n_lanes; l += width) {
                const Gathered c = gather_contacts(batch, l, at);
                const Impulses step = load(z[k], l) + beta * load(p[k], l);
                store(p[k], l, step);
                push_and_scatter<friction>(batch, l, of_p, gather(of_p, batch.a + l), gather(of_p, batch.b + l), c.nx,
                                           c.ny, step);
                sums.add(Lane{}, -((c.v_n + load(batch.bias + l)) * step.n + c.v_t * step.t));
            }
        }
        return sums.sums();
    });
}

void go_along(const BatchSpan& batches, const SearchBatch* p, double alpha, double* u) {
    by_law(batches, [&]<Friction friction, bool cohesive>() {
        const Lane zero = {};
        for (std::int64_t k = 0; k < batches.n; ++k) {
            const DiskBatch& batch = batches.contacts[k];
            for (int l = 0; l < n_lanes; l += width) {
                const Impulses r = load_impulses<friction>(batches, k, l);
                const Impulses wanted = r + alpha * load(p[k], l);
                const Impulses z = feasible<friction, cohesive>(batches, k, l, wanted.n, wanted.t, zero);
                store_impulses<friction>(batches, k, l, z);
                push_and_scatter<friction>(batch, l, u, gather(u, batch.a + l), gather(u, batch.b + l),
                                           load(batch.nx + l), load(batch.ny + l), z - r);
            }
        }
    });
}

} // namespace
} // namespace nappe

#undef NAPPE_INLINE
