// The step that smooth stages are held to, against oscillators. That no packing needs a shorter one: tests/validation.
#include "core/smooth_step.hpp"

#include "support/scene_builder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace nappe::smooth_step_test {
namespace {

using test::SceneBuilder;

constexpr double k = 4e6, r = 0.5;
constexpr double m_disk = 2800 * std::numbers::pi * r * r; // of the builder's material
constexpr double round_off = 1e-13;                        // relative, of a dozen operations

Scene<2> with_springs(SceneBuilder& b, double k_s, std::optional<double> c_n, std::optional<double> c_s, double h) {
    for (auto& law : b.scene().laws) {
        law.springs = Springs{{k, c_n}, {k_s, c_s}};
    }
    b.stage(smooth_settings(h));
    return b.scene();
}

TEST(SmoothStep, OfOnePairIsThatOfAnOscillator) {
    const double m = m_disk, w = std::sqrt(2 * k / m);
    SceneBuilder plain(0);
    plain.grain(r, {0, 0}).grain(r, {2 * r, 0});
    const double undamped = smooth_bounds(with_springs(plain, k, 0, 0, 1)).stable;
    EXPECT_NEAR(undamped * w / 2, 1, round_off);
    SceneBuilder damped(0);
    damped.grain(r, {0, 0}).grain(r, {2 * r, 0});
    const auto bounds = smooth_bounds(with_springs(damped, k, {}, {}, 1)); // m_eff = m/2: zeta = 1
    EXPECT_NEAR(bounds.stable / (2 / w * (std::sqrt(2.0) - 1)), 1, round_off);
    EXPECT_NEAR(bounds.critical / (2 * std::sqrt(m / k)), 1, round_off);
    EXPECT_EQ(bounds.spin_flips, std::numeric_limits<double>::infinity());
}

TEST(SmoothStep, TheRimOfADiskIsThreeTimesAsLight) {
    const double m = m_disk;
    SceneBuilder soft(0.5), stiff(0.5), sticky(0.5);
    for (auto* b : {&soft, &stiff, &sticky}) {
        b->floor().grain(r, {0, r});
    }
    EXPECT_NEAR(smooth_bounds(with_springs(soft, k / 4, 0, 0, 1)).stable / (2 * std::sqrt(m / k)), 1, round_off);
    const auto bounds = smooth_bounds(with_springs(stiff, k, 0, 0, 1));
    EXPECT_NEAR(bounds.stable / (2 * std::sqrt(m / (3 * k))), 1, round_off);
    EXPECT_NE(bounds.contact.find("tangential spring"), std::string::npos) << bounds.contact;
    // A dashpot without a spring: each step takes h c / (m/3) of the slip, and twice that would turn it around.
    const double c = 3e5;
    EXPECT_NEAR(smooth_bounds(with_springs(sticky, 0, 0, c, 1)).stable, 2 * m / (3 * c), round_off);
}

TEST(SmoothStep, CountsAsManyContactsAsThereIsRoomFor) {
    const auto stable = [](double r_big, int n) {
        SceneBuilder b(0);
        for (int i = 0; i < n; ++i) {
            b.grain(r, {2 * r * i, 0});
        }
        b.grain(r_big, {-r - r_big, 0});
        return smooth_bounds(with_springs(b, k, 0, 0, 1)).stable;
    };
    const double m = m_disk;
    EXPECT_NEAR(stable(r, 2) / (2 / std::sqrt(4 * k / m)), 1, round_off) << "two contacts each, of three grains";
    EXPECT_NEAR(stable(r, 20) / (2 / std::sqrt(12 * k / m)), 1, round_off) << "six around one of the same size";
    EXPECT_NEAR(stable(10 * r, 20) / (2 / std::sqrt(12 * k / m)), 1, round_off) << "no large one is as fast";
}

TEST(SmoothStep, CountsThePiecesOfAWall) {
    // One disk, and three segments that it may touch at once: 3 k on its mass.
    SceneBuilder b(0);
    b.grain(r, {0, 0}).wall("box", {{-r, 2 * r}, {-r, -r}, {r, -r}, {r, 2 * r}});
    EXPECT_NEAR(smooth_bounds(with_springs(b, k, 0, 0, 1)).stable / (2 / std::sqrt(3 * k / m_disk)), 1, round_off);
}

TEST(SmoothStep, WarnsOfWhatIsNotUnstable) {
    const double m = m_disk, inertia = 0.5 * m * r * r, critical = 2 * std::sqrt(m / k);
    const auto said = [critical](double share, double c_spin, bool unsafe = false) {
        SceneBuilder b(0);
        b.grain(r, {0, 0}).grain(r, {2 * r, 0});
        b.scene().materials[0].spin_damping = c_spin;
        auto scene = with_springs(b, k, 0, 0, share * critical);
        scene.stages[0].solver.unsafe = unsafe;
        return smooth_warnings(scene);
    };
    const double flips = 2 * inertia / (0.05 * critical); // a = 1
    EXPECT_EQ(said(0.099, 0).size(), 0u);
    ASSERT_EQ(said(0.101, 0).size(), 1u);
    EXPECT_NE(said(0.101, 0)[0].find("a tenth of dt_crit"), std::string::npos);
    EXPECT_EQ(said(0.05, 0.99 * flips).size(), 0u);
    ASSERT_EQ(said(0.05, 1.01 * flips).size(), 1u);
    EXPECT_NE(said(0.05, 1.01 * flips)[0].find("turns the spin of"), std::string::npos);
    ASSERT_EQ(said(1, 0, true).size(), 2u); // of a pair, sqrt(1/2) of the critical step is stable
    EXPECT_NE(said(1, 0, true)[0].find("is unsafe, as allowed"), std::string::npos);
    SceneBuilder rigid;
    rigid.grain(r, {0, 0}).stage(test::solver(1, 1));
    EXPECT_EQ(smooth_warnings(rigid.scene()).size(), 0u);
}

} // namespace
} // namespace nappe::smooth_step_test
