// The reference loop and the triad, one source for all instruction sets: included by bench_loops_*.cpp, each compiled
// with the flags of solver/disk_sweep_*.cpp. Unnamed namespace and no library code, for the reason given there.
//
// The reference is the loop one writes first: a struct per contact, contacts in the order of (lo id, hi id) over the
// whole sample, bodies in the order of ids. Its arithmetic is that of solver/disk_sweep.inl, operation by operation, so
// that a contact gives the same bits; only the order of contacts differs. A contact needs what the one before it wrote,
// so that no compiler can vectorise it.

#include "commands/bench_loops.hpp"

namespace nappe {
namespace {

void relax_list(ListContact* contacts, std::int64_t n, double mu, ListBody* u) {
    const double third = 1.0 / 3.0;
    for (std::int64_t k = 0; k < n; ++k) {
        ListContact& c = contacts[k];
        ListBody& a = u[c.a];
        ListBody& b = u[c.b];
        const double dvx = a.vx - b.vx, dvy = a.vy - b.vy;
        const double v_n = c.nx * dvx + c.ny * dvy;
        const double v_t = (c.nx * dvy - c.ny * dvx) - (a.s + b.s);
        const double wanted_n = c.r_n - (v_n + c.bias) * c.m_eff;
        const double new_n = wanted_n > 0 ? wanted_n : 0;
        const double limit = mu * new_n;
        const double wanted_t = c.r_t - v_t * (c.m_eff * third);
        const double above = wanted_t > limit ? limit : wanted_t;
        const double new_t = above < -limit ? -limit : above;
        const double d_n = new_n - c.r_n, d_t = new_t - c.r_t;
        c.r_n = new_n;
        c.r_t = new_t;
        const double px = d_n * c.nx - d_t * c.ny, py = d_n * c.ny + d_t * c.nx, spin = d_t + d_t;
        a.vx += px * a.inv_m;
        a.vy += py * a.inv_m;
        a.s -= spin * a.inv_m;
        b.vx -= px * b.inv_m;
        b.vy -= py * b.inv_m;
        b.s -= spin * b.inv_m;
    }
}

void triad(double* __restrict a, const double* __restrict b, const double* __restrict c, double s, std::int64_t n) {
    double* const out = static_cast<double*>(__builtin_assume_aligned(a, 64));
    const double* const p = static_cast<const double*>(__builtin_assume_aligned(b, 64));
    const double* const q = static_cast<const double*>(__builtin_assume_aligned(c, 64));
    for (std::int64_t i = 0; i < n; ++i) {
        out[i] = p[i] + s * q[i];
    }
}

} // namespace
} // namespace nappe
