#pragma once
// Where the energy of a step goes, exactly, however well its contacts converged (docs/measures.md, "Energy"). With v̄
// the mean of a velocity before and after the step, m (v'² − v²)/2 = m (v' − v)·v̄, and the step's equation of motion
// says what m (v' − v) is. By tile in the order of grains and candidates, then exactly, so that ranks do not matter.

#include "core/exact_sum.hpp"
#include "core/smooth_works.hpp"
#include "core/state.hpp"

namespace nappe {

/// Of the kinetic energy's change, together with the work of walls (ContactSums) [J]: gravity + theta_term − friction −
/// impact − cohesion − spring − dashpot − damping. The last three are of smooth stages, impact and cohesion of the others.
struct EnergyBudget {
    double gravity = 0;    ///< by the way grains went: what the potential energy lost
    double theta_term = 0; ///< of that, what did not reach velocities: −(theta − 1/2) h m g·(v' − v)
    double friction = 0;   ///< lost: −r_t ū_t; in smooth stages by what slides (smooth_works.hpp)
    double impact = 0;     ///< lost: −r_n ū_n where r_n >= 0
    double cohesion = 0;   ///< lost: −r_n ū_n where r_n < 0
    double spring = 0;     ///< put into springs, which give it back: what they hold, but for the error of the steps
    double dashpot = 0;    ///< lost in dashpots
    double damping = 0;    ///< lost by global damping: h C v̄² and h C* ω̄²

    double lost() const { return friction + impact + cohesion + spring + dashpot + damping; }
};

/// Summed over steps since the last `clear`. All members are Local.
template <int D>
class EnergySums {
public:
    /// A grain of the current tile. @param h [s]
    void add_grain(double mass, const BodyVelocity<D>& u_old, const BodyVelocity<D>& u, const Vec<D>& gravity, double h,
                   double theta) {
        double way = 0, change = 0; // along gravity
        for (int d = 0; d < D; ++d) {
            way += gravity[d] * (theta * u.v[d] + (1 - theta) * u_old.v[d]);
            change += gravity[d] * (u.v[d] - u_old.v[d]);
        }
        tile_.gravity += h * mass * way;
        tile_.theta_term -= (theta - 0.5) * h * mass * change;
    }

    /// A contact of the current tile: impulses on a along n and its tangent; velocities of its bodies before and after.
    void add_contact(const BodyVelocity<D>& a_old, const BodyVelocity<D>& a, const BodyVelocity<D>& b_old,
                     const BodyVelocity<D>& b, const Vec<D>& n, double r_n, double r_t) {
        static_assert(D == 2, "the tangent below is that of the plane");
        const double x = 0.5 * ((a_old.v[0] + a.v[0]) - (b_old.v[0] + b.v[0]));
        const double y = 0.5 * ((a_old.v[1] + a.v[1]) - (b_old.v[1] + b.v[1]));
        const double rims = 0.5 * ((a_old.s[0] + a.s[0]) + (b_old.s[0] + b.s[0]));
        const double normal = r_n * (n[0] * x + n[1] * y);
        (r_n < 0 ? tile_.cohesion : tile_.impact) -= normal;
        tile_.friction -= r_t * ((n[0] * y - n[1] * x) - rims);
    }

    /// A grain under Cundall's global damping, C [N s/m] and C* [N m s].
    void add_damping(double c, double c_spin, double radius, const BodyVelocity<D>& u_old, const BodyVelocity<D>& u,
                     double h) {
        double v2 = 0, s2 = 0;
        for (int d = 0; d < D; ++d) {
            const double mean = 0.5 * (u_old.v[d] + u.v[d]);
            v2 += mean * mean;
        }
        for (int k = 0; k < n_spin<D>; ++k) {
            const double mean = 0.5 * (u_old.s[k] + u.s[k]) / radius;
            s2 += mean * mean;
        }
        tile_.damping += h * (c * v2 + c_spin * s2);
    }

    /// A smooth contact of the current tile.
    void add_smooth(const SmoothWorks& works) {
        tile_.spring += works.spring;
        tile_.friction += works.friction;
        tile_.dashpot += works.dashpot;
    }

    void end_tile() {
        gravity_.add(tile_.gravity);
        theta_term_.add(tile_.theta_term);
        friction_.add(tile_.friction);
        impact_.add(tile_.impact);
        cohesion_.add(tile_.cohesion);
        spring_.add(tile_.spring);
        dashpot_.add(tile_.dashpot);
        damping_.add(tile_.damping);
        tile_ = {};
    }

    /// Calls f(ExactSum&) for each sum, in the same order on every rank.
    template <class F>
    void for_each_sum(F&& f) {
        for (ExactSum* sum :
             {&gravity_, &theta_term_, &friction_, &impact_, &cohesion_, &spring_, &dashpot_, &damping_}) {
            f(*sum);
        }
    }

    EnergyBudget budget() const {
        return {gravity_.value(),  theta_term_.value(), friction_.value(), impact_.value(),
                cohesion_.value(), spring_.value(),     dashpot_.value(),  damping_.value()};
    }

    void clear() {
        for_each_sum([](ExactSum& s) { s.clear(); });
    }

private:
    EnergyBudget tile_;
    ExactSum gravity_, theta_term_, friction_, impact_, cohesion_, spring_, dashpot_, damping_;
};

} // namespace nappe
