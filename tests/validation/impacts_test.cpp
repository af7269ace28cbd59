// Impacts with Newton's restitution e and Coulomb friction, against formulas of rigid disks (I = m r²/2).

#include "support/serial_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace nappe::test::impacts_test {
namespace {

constexpr double g = standard_gravity;
constexpr double ulp = std::numeric_limits<double>::epsilon();

/// A disk without spin hits a floor at v_n downwards and v_t along it. The normal impulse is m (1 + e) v_n. Its friction may reach
/// mu m (1 + e) v_n, and stopping the slip v_t (effective mass m/3) takes m v_t / 3. So it slides all through the impact if
/// tan theta = v_t / v_n >= 3 mu (1 + e): v_t' = v_t - mu (1 + e) v_n and |s'| = 2 mu (1 + e) v_n. Else it leaves rolling:
/// v_t' = (2/3) v_t = |s'|. No gravity here, so that nothing but the impact changes a velocity.
TEST(Impact, ObliqueSlidesOrSticks) {
    const double r = 0.4, h = 1e-3, v_n = 2;
    for (const double e : {0.0, 0.3, 0.8, 1.0}) {
        for (const double mu : {0.1, 0.4}) {
            for (const double ratio : {0.2, 0.95, 1.05, 3.0}) { // tan theta over 3 mu (1 + e)
                const double v_t = v_n * ratio * 3 * mu * (1 + e);
                SceneBuilder b(mu, e);
                b.gravity(0, 0).floor().grain(r, {0, r + 0.0137}, {v_t, -v_n}).stage(solver(h, 1));
                SerialRun run(b.scene());
                run.steps(20); // it touches after 0.0137 / (v_n h) = 6.85 steps
                const bool slides = ratio > 1;
                const double left = slides ? v_t - mu * (1 + e) * v_n : 2 * v_t / 3;
                const double rim = slides ? 2 * mu * (1 + e) * v_n : 2 * v_t / 3;
                // One impact of a single contact: round-off, but for e = 0, which takes two steps (to the floor, then to rest).
                const double tolerance = 1e-12;
                EXPECT_NEAR(run.grain(0).v[0], left, tolerance) << "e " << e << " mu " << mu << " ratio " << ratio;
                EXPECT_NEAR(run.rim_speed(0), -rim, tolerance) << "e " << e << " mu " << mu << " ratio " << ratio;
                EXPECT_NEAR(run.grain(0).v[1], e * v_n, tolerance) << "e " << e << " mu " << mu << " ratio " << ratio;
            }
        }
    }
}

/// Two disks meet head on: m_a v_a + m_b v_b stays, and the speed of parting is e times that of approach.
TEST(Impact, CentralOfTwoDisksKeepsMomentumAndRecoversE) {
    const double m_a = disk_mass(0.5), m_b = disk_mass(0.3);
    const double v_a = 3, v_b = -1;
    for (const double e : {0.0, 0.25, 0.7, 1.0}) {
        SceneBuilder b(0.4, e);
        const Vec<2> along = Vec<2>(3, 4) / 5; // off the axes, so that both components work
        b.gravity(0, 0).grain(0.5, {0, 0}, v_a * along).grain(0.3, 0.8173 * along, v_b * along).stage(solver(1e-3, 1));
        SerialRun run(b.scene());
        run.steps(20);
        const auto speed = [&](GlobalId id) { return run.grain(id).v[0] * along[0] + run.grain(id).v[1] * along[1]; };
        const double centre = (m_a * v_a + m_b * v_b) / (m_a + m_b);
        const double tolerance = 1e-12; // round-off of one impact
        EXPECT_NEAR(m_a * speed(0) + m_b * speed(1), (m_a + m_b) * centre, (m_a + m_b) * tolerance) << e;
        EXPECT_NEAR(speed(1) - speed(0), e * (v_a - v_b), tolerance) << e;
        EXPECT_NEAR(run.grain(0).spin[0], 0, tolerance) << e;
        EXPECT_NEAR(run.grain(1).spin[0], 0, tolerance) << e;
    }
}

/// Dropped from 1 m with e = 0.5 a disk leaves at half its speed and so rises to e² = 0.25 m. An impact may be brought forward by the
/// step and a half over which the contact condition looks ahead: it then happens up to 1.5 h |v| above the floor (|v| = sqrt(2 g) =
/// 4.43 m/s), and late by a step of gravity in v. Both move the apex by less than 1.5 h |v| + e h |v|: 9 h, in metres.
TEST(Impact, DropReboundsToESquared) {
    const double r = 0.5, e = 0.5;
    for (const double h : {4e-3, 1e-3, 2.5e-4}) {
        SceneBuilder b(0, e);
        b.floor().grain(r, {0, r + 1}).stage(solver(h, 1));
        SerialRun run(b.scene());
        bool touched = false;
        double apex = 0;
        for (int n = 0; n * h < 0.85; ++n) { // it falls 0.45 s and is up again 0.23 s later
            run.steps(1);
            touched = touched || run.grain(0).v[1] > 0;
            apex = touched ? std::max(apex, run.grain(0).x[1] - r) : 0;
        }
        ASSERT_TRUE(touched);
        EXPECT_NEAR(apex, 0.25, 9 * h) << h;
    }
}

/// Time after which a disk dropped from `height` has done bouncing: the last step that it ends with more than two steps' worth of
/// gravity upwards; what is left of the series then is 2 (2 g h) / g / (1 - e) = O(h).
double time_to_rest(double height, double e, double h) {
    SceneBuilder b(0, e);
    const double r = 0.5;
    b.floor().grain(r, {0, r + height}).stage(solver(h, 1));
    SerialRun run(b.scene());
    double last = 0;
    const double enough = 1.5 * std::sqrt(2 * height / g) * (1 + e) / (1 - e);
    for (int n = 1; n * h < enough; ++n) {
        run.steps(1);
        last = run.grain(0).v[1] > 2 * g * h ? n * h : last;
    }
    EXPECT_NEAR(run.grain(0).v[1], 0, 10 * ulp) << "not at rest after half as long again";
    EXPECT_NEAR(run.grain(0).x[1], r, g * h * h) << "rests in the air";
    return last;
}

/// The fall takes t_0 = sqrt(2 H / g), the k-th bounce 2 e^k t_0: at rest after t_0 (1 + 2 e / (1 - e)) = t_0 (1 + e) / (1 - e).
/// Every impact is early or late by up to 1.5 h (above) and so scales what follows by as much: order 1, over phases at worst.
TEST(Impact, BouncingStopsAfterTheGeometricSeries) {
    const double e = 0.6;
    std::vector<double> worst;
    for (const double h : {8e-3, 4e-3, 2e-3, 1e-3}) {
        double largest = 0;
        for (int k = 0; k < 12; ++k) { // heights, so that impacts fall anywhere within a step
            const double height = 1 + 0.037 * k;
            const double exact = std::sqrt(2 * height / g) * (1 + e) / (1 - e);
            largest = std::max(largest, std::abs(time_to_rest(height, e, h) - exact));
        }
        worst.push_back(largest);
        // 1.5 h for each impact, multiplied by the duration it still governs over its own, (1 + e) / (1 - e), summed over the series.
        EXPECT_LT(largest, 1.5 * h * (1 + e) / (1 - e) / (1 - e));
    }
    const double order = std::log2(worst.front() / worst.back()) / 3;
    // Order 1; a logarithm of h (the number of bounces until they are as small as a step) and a worst case over 12 phases blur it.
    EXPECT_NEAR(order, 1.0, 0.25);
}

/// An overlap that is already there (a deposit's, or an unconverged step's) is not pushed out: it would be energy from nothing.
TEST(Impact, OverlapIsNotPushedOut) {
    const double r = 0.5, sunk = 0.02;
    for (const double e : {0.0, 0.5}) {
        SceneBuilder b(0.4, e);
        b.floor().grain(r, {0, r - sunk}).grain(r, {0, 3 * r - 2 * sunk}).stage(solver(1e-3, 100));
        SerialRun run(b.scene());
        run.steps(100);
        EXPECT_NEAR(run.grain(0).x[1], r - sunk, 1e-12) << e;
        EXPECT_NEAR(run.grain(1).x[1], 3 * r - 2 * sunk, 1e-12) << e;
        EXPECT_NEAR(run.normal_impulse(0, wall_id(0)), 2 * disk_mass(r) * g * 1e-3, 1e-9 * disk_mass(r)) << e;
    }
}

/// e = 0: after the impact the disk stays where it is, at the floor, and has neither sunk nor been thrown back.
TEST(Impact, InelasticSticks) {
    const double r = 0.5, h = 1e-3;
    for (const double drop : {0.0, 0.01, 1.0}) {
        SceneBuilder b(0.4, 0);
        b.floor().grain(r, {0, r + drop}).stage(solver(h, 1));
        SerialRun run(b.scene());
        const int landed = static_cast<int>(std::sqrt(2 * drop / g) / h) + 3; // to the floor, then to rest
        for (int n = 0; n < landed + 500; ++n) {
            run.steps(1);
            EXPECT_LE(run.grain(0).v[1], 10 * ulp) << "thrown back in step " << n;
            if (n >= landed) {
                EXPECT_NEAR(run.grain(0).v[1], 0, 10 * ulp);
            }
        }
        // It comes to rest from the middle of a step, half of a step's way above the floor or below.
        EXPECT_NEAR(run.grain(0).x[1], r, 0.5 * h * (std::sqrt(2 * g * drop) + g * h) + 10 * ulp) << drop;
    }
}

} // namespace
} // namespace nappe::test::impacts_test
