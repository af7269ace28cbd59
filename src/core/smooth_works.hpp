#pragma once
// Where the work of one smooth contact goes in one step (docs/measures.md, "Energy"), from what is known of it when its
// forces have acted (solver/disk_smooth.inl): impulses r_n and r_t, of which s h is the tangential spring's. Spring and
// dashpot pull side by side, with Coulomb's slider in series.

#include "core/scene.hpp"

namespace nappe {

/// A dashpot's constant between bodies of 1/m_a + 1/m_b = 1/m_eff [N s/m].
inline double dashpot_of(const SpringDashpot& given, double m_eff) {
    return given.c ? *given.c : 2 * std::sqrt(m_eff * given.k);
}

/// Of two bodies at their contact: before the step, after it; opening and along the tangent [m/s].
struct SmoothMotion {
    double n_old = 0, t_old = 0;
    double n = 0, t = 0;

    double n_mean() const { return 0.5 * (n_old + n); }
    double t_mean() const { return 0.5 * (t_old + t); }
};

struct SmoothContact {
    double h = 0;            ///< [s]
    double r_n = 0, r_t = 0; ///< on body a [N s]
    double s = 0, s_old = 0; ///< of r_t, the spring's part; what it was in the step before [N s]
    double c_n = 0, c_s = 0; ///< [N s/m]
    double k_n = 0, k_s = 0; ///< [N/m]
    double mu = 0;
    SmoothMotion v;
};

/// Taken from the bodies [J]; the sum is −r_n ū_n − r_t ū_t.
struct SmoothWorks {
    double spring = 0, friction = 0, dashpot = 0;
};

/// What slides is what the spring was not stretched by, at the spring's force; and of what a dashpot that Coulomb's limit
/// cuts takes, the share that is cut.
inline SmoothWorks works_of(const SmoothContact& c) {
    SmoothWorks works;
    const double dashed = -c.h * c.c_n * c.v.n_old; // of r_n
    works.dashpot = -dashed * c.v.n_mean();
    works.spring = -(c.r_n - dashed) * c.v.n_mean();

    const double stretched = c.s_old - (c.h * c.h) * (c.k_s * c.v.t_old);
    if (c.k_s > 0 && stretched != c.s) { // the way of the slider, moved to the middle of the step as all works are
        const double way = -(stretched - c.s) / (c.h * c.k_s) + c.h * (c.v.t_mean() - c.v.t_old);
        works.friction = -c.s / c.h * way;
    }
    works.spring += -c.s * c.v.t_mean() - works.friction;

    const double rest = c.r_t - c.s, wanted = -c.h * (c.c_s * c.v.t_old);
    const double taken = -rest * c.v.t_mean();
    const double share = wanted != 0 ? rest / wanted : 1.0;
    works.dashpot += share * taken;
    works.friction += taken - share * taken;
    return works;
}

/// What the springs of a contact hold, and what the step changed of it [J]: at the velocities' time, k/2 times the product of
/// the overlaps before and after, which with the kinetic energy is what central differences keep of an oscillation.
struct SpringEnergy {
    double held = 0, gained = 0;
};

inline SpringEnergy spring_energy(const SmoothContact& c) {
    const double overlap = (c.r_n / c.h + c.c_n * c.v.n_old) / c.k_n;
    const double before = overlap + c.h * c.v.n_old, after = overlap - c.h * c.v.n;
    SpringEnergy energy;
    energy.held = 0.5 * c.k_n * overlap * overlap;
    energy.gained = 0.5 * c.k_n * overlap * ((after > 0 ? after : 0.0) - (before > 0 ? before : 0.0));
    if (c.k_s > 0) {
        const double limit = c.mu * (c.r_n < 0 ? -c.r_n : c.r_n);
        const auto clamped = [limit](double s) { return s > limit ? limit : s < -limit ? -limit : s; };
        const double one = c.h * c.h * c.k_s;
        const double next = clamped(c.s - one * c.v.t);
        // One that is at its limit was there before.
        const bool slides = (c.s < 0 ? -c.s : c.s) >= limit * (1 - 1e-12);
        const double last = slides ? c.s : clamped(c.s + one * c.v.t_old);
        energy.held += 0.5 * c.s * c.s / one;
        energy.gained += 0.5 * c.s * (next - last) / one;
    }
    return energy;
}

} // namespace nappe
