// Laws that differ within one scene, and instruction sets that must not.

#include "support/serial_run.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace nappe::test::laws_test {
namespace {

constexpr double g = standard_gravity;

bool machine_has(const std::string& kernel) {
#if defined(__x86_64__)
    if (kernel == "avx2") {
        return __builtin_cpu_supports("avx2");
    }
    if (kernel == "avx512") {
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl");
    }
#endif
    return kernel == "portable";
}

/// One test for each instruction set; skipped only where the machine lacks it.
class Kernels : public testing::TestWithParam<const char*> {
protected:
    void SetUp() override {
        if (!machine_has(GetParam())) {
            GTEST_SKIP() << "this machine has no " << GetParam();
        }
    }
};

/// Disks of two materials slide on one floor, each at the deceleration mu g of its own law, as long as it slides (one_body_test.cpp);
/// ten of each, so that batches hold both.
TEST_P(Kernels, EachPairHasItsOwnFriction) {
    const double h = 1e-3, v0 = 4, r = 0.5;
    const double mu[] = {0.15, 0.6};
    SceneBuilder b(0.9);
    const int other = b.material("other"), ground = b.material("ground");
    b.law(0, ground, mu[0]).law(other, ground, mu[1]).law(0, other, 0.3);
    b.floor(1000, ground);
    for (int k = 0; k < 20; ++k) {
        b.grain(r, {5.0 * k, r}, {v0, 0}, 0, k % 2 == 0 ? 0 : other);
    }
    b.stage(solver(h, 1));
    SerialRun run(b.scene(), GetParam());
    const int n = 100; // the rougher one would slide until v0 / (3 mu g) = 0.226 s
    run.steps(n);
    for (int k = 0; k < 20; ++k) {
        const double tolerance = 2 * n * v0 * 2.3e-16;
        EXPECT_NEAR(run.grain(k).v[0], v0 - mu[k % 2] * g * n * h, tolerance) << k;
        EXPECT_NEAR(run.rim_speed(k), -2 * mu[k % 2] * g * n * h, tolerance) << k;
    }
}

/// Restitution by pair: two disks dropped on one floor, only one of which rebounds.
TEST_P(Kernels, EachPairHasItsOwnRestitution) {
    const double h = 1e-3, r = 0.5;
    SceneBuilder b(0.2, 0.9);
    const int dead = b.material("dead");
    b.law(0, dead, 0.2, 0);
    b.floor().grain(r, {0, r + 0.2}, {0, -2}).grain(r, {5, r + 0.2}, {0, -2}, 0, dead);
    b.gravity(0, 0).stage(solver(h, 1));
    SerialRun run(b.scene(), GetParam());
    run.steps(150);
    EXPECT_NEAR(run.grain(0).v[1], 0.9 * 2, 1e-12);
    EXPECT_NEAR(run.grain(1).v[1], 0, 1e-12);
}

/// A pile of about 300 disks that falls together while a wall drives through it.
Scene<2> pushed_pile(bool mixed) {
    SceneBuilder b(0.4);
    const int wall = b.material("wall");
    b.law(0, wall, mixed ? 0.1 : 0.4);
    b.box(20, 7, {RadiusLaw::Kind::uniform, 0.3, 0.4}, 3, wall);
    Motion<2> motion;
    motion.velocity = {0.5, 0};
    b.scene().walls[1].motion = motion;
    b.stage(solver(5e-3, 20));
    return b.scene();
}

/// The last bit of every position, velocity, rotation and impulse.
TEST_P(Kernels, GiveTheSameBits) {
    for (const bool mixed : {false, true}) {
        SerialRun portable(pushed_pile(mixed), "portable"), other(pushed_pile(mixed), GetParam());
        ASSERT_GT(portable.state().n_own, 250);
        EXPECT_STREQ(other.simulation().contacts().instruction_set(), GetParam());
        const auto at_start = portable.simulation().state_hash();
        portable.steps(50);
        other.steps(50);
        EXPECT_EQ(portable.simulation().state_hash(), other.simulation().state_hash()) << (mixed ? "mixed" : "uniform");
        EXPECT_NE(portable.simulation().state_hash(), at_start);
    }
}

INSTANTIATE_TEST_SUITE_P(All, Kernels, testing::Values("portable", "avx2", "avx512"),
                         [](const auto& kernel) { return std::string(kernel.param); });

} // namespace
} // namespace nappe::test::laws_test
