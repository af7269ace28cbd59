// One disk in the air, on a floor, on a slope, against formulas of rigid bodies with I = m r²/2.
//
// Kinetics on a floor, used all through: at the contact the tangential effective mass is m/3 (1/m + r²/I = 3/m). A force F
// there changes the centre's velocity v at F/m and the rim speed s at 2 F/m, so the slip v + s (s counted so that rolling along +x
// has s = -v) changes at 3 F/m.

#include "support/serial_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace nappe::test::one_body_test {
namespace {

constexpr double g = standard_gravity;
constexpr double ulp = std::numeric_limits<double>::epsilon();

/// Free flight: x = x0 + v0 t + g t²/2. The scheme sums h (theta v_i+1 + (1 - theta) v_i); with v linear in time, the trapezoidal part
/// (theta = 1/2) is exact and the rest telescopes to (theta - 1/2) h (v_n - v_0) = (theta - 1/2) h g t.
TEST(OneBody, FreeFlightIsExactButForThetasShare) {
    const double h = 1e-3;
    const int n = 1000;
    const double t = n * h;
    for (const double theta : {0.5, 0.6, 0.75, 1.0}) {
        SceneBuilder b;
        b.gravity(1.5, -g).grain(0.5, {1, 2}, {3, 4}, 7).stage(solver(h, 1, theta));
        SerialRun run(b.scene());
        run.steps(n);
        const auto end = run.grain(0);
        // Positions below 10 m are rounded once or twice a step.
        const double tolerance = 2 * n * 10 * ulp;
        EXPECT_NEAR(end.x[0], 1 + 3 * t + 0.5 * 1.5 * t * t + (theta - 0.5) * h * 1.5 * t, tolerance) << theta;
        EXPECT_NEAR(end.x[1], 2 + 4 * t - 0.5 * g * t * t - (theta - 0.5) * h * g * t, tolerance) << theta;
        EXPECT_NEAR(end.v[1], 4 - g * t, tolerance);
        EXPECT_NEAR(end.spin[0], 7, 10 * ulp);
        EXPECT_NEAR(end.rotation[0], 7 * t, tolerance);
    }
}

/// A disk that rolls keeps v and s whatever theta is, since neither changes; the floor carries its weight and no more.
TEST(OneBody, SteadyRollingIsExact) {
    const double h = 1e-3, r = 0.37, v0 = 2.3;
    const int n = 2000;
    for (const double theta : {0.5, 0.75, 1.0}) {
        SceneBuilder b(0.4);
        b.floor().grain(r, {-2, r}, {v0, 0}, -v0 / r).stage(solver(h, 1, theta));
        SerialRun run(b.scene());
        run.steps(n);
        const auto end = run.grain(0);
        const double tolerance = 2 * n * 10 * ulp; // as above; friction of round-off size acts at random
        EXPECT_NEAR(end.v[0], v0, tolerance);
        EXPECT_NEAR(end.spin[0], -v0 / r, tolerance / r);
        EXPECT_NEAR(end.x[0], -2 + v0 * n * h, tolerance);
        EXPECT_NEAR(end.x[1], r, 10 * ulp);
        EXPECT_NEAR(end.rotation[0], -v0 * n * h / r, tolerance / r);
        EXPECT_NEAR(run.normal_impulse(0, wall_id(0)), disk_mass(r) * g * h, 1e-12 * disk_mass(r) * g * h);
    }
}

struct SlideToRoll {
    double v = 0, s = 0, x = 0;
};

/// Thrown without spin at v0 along the floor, after n steps.
SlideToRoll slide_to_roll(double v0, double mu, double h, int n, double theta) {
    SceneBuilder b(mu);
    const double r = 0.5;
    b.floor(1000).grain(r, {0, r}, {v0, 0}).stage(solver(h, 1, theta));
    SerialRun run(b.scene());
    run.steps(n);
    return {run.grain(0).v[0], run.rim_speed(0), run.grain(0).x[0]};
}

/// Sliding: v = v0 - mu g t and s = -2 mu g t until the slip v0 - 3 mu g t ends at t* = v0 / (3 mu g); then v = (2/3) v0 = -s
/// for good. The scheme has v and s of the sliding exactly, and sticks in the very step in which t* lies.
TEST(OneBody, SlidesThenRolls) {
    const double mu = 0.3, v0 = 5, h = 1e-3;
    const double t_star = v0 / (3 * mu * g);
    const auto before = static_cast<int>(t_star / h);
    const double tolerance = 2 * before * v0 * ulp;
    for (const int n : {1, before / 2, before}) {
        const auto end = slide_to_roll(v0, mu, h, n, 0.5);
        EXPECT_NEAR(end.v, v0 - mu * g * n * h, tolerance);
        EXPECT_NEAR(end.s, -2 * mu * g * n * h, tolerance);
    }
    for (const int n : {before + 1, 2 * before}) {
        const auto end = slide_to_roll(v0, mu, h, n, 0.5);
        EXPECT_NEAR(end.v, 2 * v0 / 3, 2 * tolerance);
        EXPECT_NEAR(end.s, -2 * v0 / 3, 2 * tolerance);
    }
}

/// With theta = 1/2 only the step that holds t* = (k + phi) h errs: there the velocity has a kink, and the trapezoid over it is
/// mu g h² phi (1 - phi) / 2 too long: mu g h² / 8 at worst, phi = 1/2. So the order is 2.
TEST(OneBody, SlideToRollHasOrderTwoInThePosition) {
    const double mu = 0.3, v0 = 5;
    const double t_star = v0 / (3 * mu * g);
    const double x_star = v0 * t_star - 0.5 * mu * g * t_star * t_star;
    std::vector<double> worst;
    for (const int k : {20, 40, 80, 160}) {
        double largest = 0;
        for (int sixteenth = 0; sixteenth < 16; ++sixteenth) {
            const double phi = sixteenth / 16.0;
            const double h = t_star / (k + phi);
            const int n = 2 * k;
            const double exact = x_star + 2 * v0 / 3 * (n * h - t_star);
            const double error = slide_to_roll(v0, mu, h, n, 0.5).x - exact;
            // 1e-11: round-off of 300 steps at 10 m, and of t* as a step's end.
            EXPECT_NEAR(error, mu * g * h * h * phi * (1 - phi) / 2, 1e-11) << "k " << k << " phi " << phi;
            largest = std::max(largest, std::abs(error));
        }
        worst.push_back(largest);
    }
    for (std::size_t i = 1; i < worst.size(); ++i) {
        // h is not quite halved: t*/(k + 1/2); the ratio differs from 4 by 2/k at most.
        EXPECT_NEAR(std::log2(worst[i - 1] / worst[i]), 2.0, 0.1);
    }
}

/// With theta = 1 the same position is short by h (v0 - (2/3) v0) / 2 besides: order 1 (see FreeFlightIsExactButForThetasShare).
TEST(OneBody, SlideToRollHasOrderOneAtThetaOne) {
    const double mu = 0.3, v0 = 5, h = 1e-3;
    const int n = 1000;
    const double half = slide_to_roll(v0, mu, h, n, 0.5).x, one = slide_to_roll(v0, mu, h, n, 1.0).x;
    EXPECT_NEAR(one - half, -0.5 * h * v0 / 3, 1e-11);
}

/// On a slope of angle a a disk rolls with (2/3) g sin a, for which it needs friction (1/3) m g sin a <= mu m g cos a: if
/// tan a <= 3 mu. Beyond, it slides with g (sin a - mu cos a) and s grows at 2 mu g cos a. The slope is a tilted gravity.
TEST(OneBody, RollsOrSlidesDownASlope) {
    const double mu = 0.25, h = 1e-3, r = 0.5;
    const int n = 500;
    const double t = n * h;
    for (const double ratio : {0.3, 0.9, 0.999, 1.001, 1.2, 2.0}) { // tan a over 3 mu
        const double a = std::atan(3 * mu * ratio);
        SceneBuilder b(mu);
        b.gravity(g * std::sin(a), -g * std::cos(a)).floor().grain(r, {0, r}).stage(solver(h, 1));
        SerialRun run(b.scene());
        run.steps(n);
        const double rolling = 2.0 / 3.0 * g * std::sin(a);
        const double sliding = g * (std::sin(a) - mu * std::cos(a));
        const double acceleration = ratio <= 1 ? rolling : sliding;
        const double rim = ratio <= 1 ? rolling : 2 * mu * g * std::cos(a);
        const double tolerance = 4 * n * 5 * ulp; // round-off of velocities up to 5 m/s
        EXPECT_NEAR(run.grain(0).v[0], acceleration * t, tolerance) << ratio;
        EXPECT_NEAR(run.rim_speed(0), -rim * t, tolerance) << ratio;
        EXPECT_NEAR(run.grain(0).x[0], 0.5 * acceleration * t * t, tolerance) << ratio;
    }
}

} // namespace
} // namespace nappe::test::one_body_test
