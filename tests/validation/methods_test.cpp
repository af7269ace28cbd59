// The contact solvers against each other and against statics, and what steers them.

#include "solver/momentum_schedule.hpp"
#include "solver/rounded_sum.hpp"
#include "support/serial_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace nappe::test::methods_test {
namespace {

constexpr double g = standard_gravity;
using Method = SolverSettings::Method;

struct NamedMethod {
    const char* name;
    Method method;
};
constexpr NamedMethod methods[] = {{"nsgs", Method::nsgs},
                                   {"ansgs", Method::ansgs},
                                   {"nncg", Method::nncg},
                                   {"apgd", Method::apgd},
                                   {"cpg", Method::cpg}};

SolverSettings to_tolerance(Method method, double tolerance, int most) {
    auto settings = solver(0.01, 10);
    settings.method = method;
    settings.tolerance = tolerance;
    settings.max_sweeps = most;
    return settings;
}

/// n disks of mass m on top of each other at rest: contact k carries (n - k) m g h, whoever solves it. From nothing: the
/// force error over the weight is n times the residual at most (tests/extremes/heavy_test.cpp).
TEST(Methods, AColumnCarriesItsWeight) {
    const double r = 0.5;
    const int n = 8;
    for (const auto& [name, method] : methods) {
        const auto settings = to_tolerance(method, 1e-8, 5000);
        SceneBuilder b(0.4);
        b.floor();
        for (int k = 0; k < n; ++k) {
            b.grain(r, {0, r * (2 * k + 1)});
        }
        b.stage(settings);
        SerialRun run(b.scene());
        run.steps(1, true);
        EXPECT_LE(run.simulation().last_residual()->largest, 1e-8) << name;
        const double weight = disk_mass(r) * g * settings.h;
        for (int k = 0; k < n; ++k) {
            const double found = k == 0 ? run.normal_impulse(0, wall_id(0)) : run.normal_impulse(k - 1, k);
            EXPECT_NEAR(found, (n - k) * weight, n * n * weight * 1e-8) << name << ", contact " << k;
        }
    }
}

/// A disk pushed along a floor slides until t* = v0/(3 mu g): friction at its bound is solved by every method
/// (docs of validation: v = v0 - mu g t, exact for constant forces).
TEST(Methods, FrictionAtItsBound) {
    const double r = 0.5, v0 = 2, mu = 0.3;
    for (const auto& [name, method] : methods) {
        auto settings = solver(0.01, 30);
        settings.method = method;
        SceneBuilder b(mu);
        b.floor().grain(r, {0, r}, {v0, 0}).stage(settings);
        SerialRun run(b.scene());
        run.steps(10);
        EXPECT_NEAR(run.grain(0).v[0], v0 - mu * g * 0.1, 1e-9 * v0) << name;
        EXPECT_NEAR(run.rim_speed(0), -2 * mu * g * 0.1, 1e-9 * v0) << name;
    }
}

/// A frictional deposit between walls, one step from nothing: all methods agree on the resultant, the weight on the
/// floor and the walls' balance (single forces are not unique), as far as their residual says.
TEST(Methods, ADepositRestsOnTheFloor) {
    for (const auto& [name, method] : methods) {
        if (method == Method::cpg || method == Method::nncg) {
            continue; // thousands of sweeps with friction: docs/accuracy.md
        }
        SceneBuilder b(0.4);
        b.box(6, 3, {RadiusLaw::Kind::uniform, 0.2, 0.3})
            .stage(solver(5e-3, 200))
            .stage(to_tolerance(method, 1e-6, 20000));
        SerialRun run(b.scene());
        run.steps(400);
        run.simulation().start_stage(1);
        run.steps(1, true);
        EXPECT_LE(run.simulation().last_residual()->largest, 1e-6) << name;
        double up = 0;
        for (const auto& row : run.loaded_contacts()) {
            if (row.wall >= 0) {
                up += row.r_n * row.normal[1] + row.r_t[0] * row.normal[0];
            }
        }
        // What is not carried is momentum gained: at rest already, so below the residual times the mass, layers deep.
        const double weight = run.simulation().total_mass() * g * 0.01;
        EXPECT_NEAR(up, weight, 1e-3 * weight) << name;
    }
}

/// Momentum is worth it where information has far to go: Gauss–Seidel needs sweeps as the square of a stack's height,
/// with momentum they grow as the height. 40 disks: expected 1/5 or less, asked 1/3.
TEST(Methods, MomentumSavesSweepsOnAStack) {
    const auto sweeps = [](Method method) {
        SceneBuilder b(0);
        b.floor();
        for (int k = 0; k < 40; ++k) {
            b.grain(0.5, {0, 0.5 * (2 * k + 1)});
        }
        b.stage(to_tolerance(method, 1e-6, 100000));
        SerialRun run(b.scene());
        run.steps(1, true);
        EXPECT_LE(run.simulation().last_residual()->largest, 1e-6);
        return run.simulation().last_sweeps();
    };
    const int plain = sweeps(Method::nsgs);
    EXPECT_LT(3 * sweeps(Method::ansgs), plain);
    EXPECT_LT(3 * sweeps(Method::apgd), plain);
    EXPECT_LT(sweeps(Method::nncg), plain);
}

TEST(MomentumSchedule, GrowsAndIsDroppedUphill) {
    MomentumSchedule schedule(1);
    EXPECT_EQ(schedule.beta(), 0);
    // theta_0 = 1, theta_1 = (sqrt 5 - 1)/2: beta_0 = 0; then beta grows towards 1.
    schedule.next(1, 1);
    EXPECT_EQ(schedule.beta(), 0);
    double before = 0;
    for (int k = 0; k < 50; ++k) {
        schedule.next(1, 1);
        EXPECT_GT(schedule.beta(), before);
        EXPECT_LT(schedule.beta(), 1);
        before = schedule.beta();
    }
    EXPECT_GT(before, 0.9);
    auto uphill = schedule, growing = schedule, steady = schedule;
    uphill.next(1, -1e-9);
    EXPECT_EQ(uphill.beta(), 0);
    growing.next(2.001, 1);
    EXPECT_EQ(growing.beta(), 0);
    steady.next(1.999, 1);
    EXPECT_GT(steady.beta(), before);
    uphill.next(1, 1);
    EXPECT_GT(uphill.beta(), 0) << "theta is doubled, not put to 1: momentum is back at once";
}

/// In any order and in any parts the same bits, and within n units of the true sum.
TEST(RoundedSum, DoesNotDependOnOrder) {
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::vector<double> terms(1000);
    long double truth = 0;
    for (auto& term : terms) {
        term = std::ldexp(uniform(random), static_cast<int>(random() % 30) - 30);
        truth += term;
    }
    const double scale = 3;
    const auto sum = [&](std::size_t part) {
        RoundedSum total(scale);
        const auto rounding = total.rounding();
        for (std::size_t begin = 0; begin < terms.size(); begin += part) {
            double of_part = 0;
            for (std::size_t k = begin; k < std::min(begin + part, terms.size()); ++k) {
                of_part += (terms[k] + rounding.magic) - rounding.magic;
            }
            total.add(of_part);
        }
        return total.value();
    };
    const double one_by_one = sum(1);
    EXPECT_NEAR(one_by_one, static_cast<double>(truth), 1000 * std::ldexp(scale, -29));
    EXPECT_NE(one_by_one, 0);
    for (const std::size_t part : {3u, 64u, 1000u}) {
        EXPECT_EQ(sum(part), one_by_one);
        std::shuffle(terms.begin(), terms.end(), random);
        EXPECT_EQ(sum(part), one_by_one);
    }
}

} // namespace
} // namespace nappe::test::methods_test
