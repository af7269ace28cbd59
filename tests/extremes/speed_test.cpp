// Speeds to 1,000 m/s, and grains that go several radii in a step: never through anything, or the user hears of it.

#include "extremes/findings.hpp"

#include <gtest/gtest.h>

namespace nappe::test {
namespace {

constexpr double r = 0.5;

/// Tiles wide enough that a grain may go `stride` in a step: from where it is to the middle of the next is 1.5 strides,
/// and S/4 - r_max is what tiles allow.
void allow(SceneBuilder& b, double stride, double r_max) {
    b.scene().tiles.side = 8 * (stride + r_max);
}

/// Head on, at any phase within a step: detection positions are one step's way apart, and a gap that closes in it is a
/// contact. Whatever the stride, the two part with e of their approach and momentum is kept.
TEST(Speeds, HeadOn) {
    for (const double speed : decades(1, 1000)) {
        for (const double stride : {0.1, 1.0, 3.0, 10.0, 100.0}) { // radii per step
            for (const double e : {0.0, 0.5, 1.0}) {
                for (int phase = 0; phase < 10; ++phase) {
                    const double h = stride * r / speed, apart = (2.5 + 1.3 * stride + 0.1 * phase * stride) * r;
                    SceneBuilder b(0, e);
                    b.gravity(0, 0).grain(r, {0, 0}, {speed, 0}).grain(r, {apart, 0});
                    allow(b, stride * r, r);
                    b.stage(solver(h, 50));
                    SerialRun run(b.scene());
                    run.steps(10);
                    ASSERT_LT(run.grain(0).x[0], run.grain(1).x[0]) << stride << " radii a step, e " << e;
                    EXPECT_NEAR(run.grain(0).v[0], (1 - e) / 2 * speed, 1e-9 * speed) << stride << ", e " << e;
                    EXPECT_NEAR(run.grain(1).v[0], (1 + e) / 2 * speed, 1e-9 * speed) << stride << ", e " << e;
                }
            }
        }
    }
}

/// A first step has no step before it: the way to its middle may lead through another grain, and that is refused.
TEST(Speeds, FirstStepThroughAGrainIsRefused) {
    for (const double stride : {1.0, 2.0, 3.0, 5.0, 10.0, 100.0}) {
        for (const double apart : {2.0, 2.5, 3.0, 5.0, 11.0, 40.0}) {
            SceneBuilder b(0, 0);
            b.gravity(0, 0).grain(r, {0, 0}, {1000, 0}).grain(r, {apart * r, 0});
            allow(b, stride * r, r);
            b.stage(solver(stride * r / 1000, 50));
            SerialRun run(b.scene());
            const auto said = run_or_refusal(run, 5);
            const bool meets = stride / 2 > apart - 1; // half a step on, centre within the other: or beyond it
            EXPECT_EQ(said.find("grains 0 and 1") != std::string::npos, meets)
                << stride << ", " << apart << ": " << said;
            if (said.empty()) {
                EXPECT_LT(run.grain(0).x[0], run.grain(1).x[0]) << stride << ", " << apart;
            }
        }
    }
}

/// Against a wall: stopped by it, or the first step leads through it and is refused.
TEST(Speeds, Wall) {
    for (const double stride : {0.1, 1.0, 2.0, 5.0, 10.0, 100.0}) {
        for (const double apart : {1.1, 2.0, 2.5, 3.0, 5.0, 11.0, 60.0}) {
            for (const double e : {0.0, 1.0}) {
                SceneBuilder b(0, e);
                b.gravity(0, 0).wall("wall", {{0, -1000}, {0, 1000}}).grain(r, {-apart * r, 0}, {1000, 0});
                allow(b, stride * r, r);
                b.stage(solver(stride * r / 1000, 50));
                SerialRun run(b.scene());
                const auto said = run_or_refusal(run, static_cast<std::int64_t>(apart / stride) + 5);
                EXPECT_EQ(said.find("went through wall 'wall'") != std::string::npos, stride / 2 > apart)
                    << stride << ", " << apart << ": " << said;
                if (said.empty()) {
                    EXPECT_LE(run.grain(0).x[0], 0);
                    EXPECT_NEAR(run.grain(0).v[0], -e * 1000, 1e-6) << stride << ", " << apart;
                }
            }
        }
    }
}

/// One hits a second that hits a third in the same step. An inelastic contact is foreseen from its gap; one with e > 0 acts
/// only on who approached when the step began, so that the second may run into the third, and through it if strides are
/// long: that is refused.
TEST(Speeds, OneBehindTheOther) {
    for (const double e : {0.0, 0.5, 1.0}) {
        for (const double stride : {0.1, 0.5, 1.0, 3.0, 10.0}) {
            double deepest = 0;
            int refused = 0, runs = 0;
            for (int phase = 0; phase < 10; ++phase) {
                for (const double gap : {0.0, 0.1, 1.0}) {
                    const double speed = 1000, first = (2.2 + 1.3 * stride + 0.1 * phase * stride) * r;
                    SceneBuilder b(0, e);
                    b.gravity(0, 0)
                        .grain(r, {0, 0}, {speed, 0})
                        .grain(r, {first, 0})
                        .grain(r, {first + 2 * r + gap * r, 0});
                    allow(b, stride * r, r);
                    b.stage(solver(stride * r / speed, 200));
                    SerialRun run(b.scene());
                    const auto said = run_or_refusal(
                        run, 20, [&] { deepest = std::max(deepest, overlaps(run.simulation()).largest); });
                    ++runs;
                    refused += said.empty() ? 0 : 1;
                    if (said.empty()) {
                        EXPECT_NEAR(momentum(run)[0], disk_mass(r) * speed, 1e-9 * disk_mass(r) * speed);
                        EXPECT_LT(run.grain(0).x[0], run.grain(1).x[0]) << stride << ", e " << e;
                        EXPECT_LT(run.grain(1).x[0], run.grain(2).x[0]) << stride << ", e " << e;
                    }
                }
            }
            found("one behind the other", e, stride, digits(deepest), fmt::format("{} of {}", refused, runs));
            EXPECT_TRUE(e > 0 || (refused == 0 && deepest < 1e-9)) << stride;
        }
    }
}

/// A bullet a thousandth of the other's size, hundreds of its own radii a step.
TEST(Speeds, BulletAgainstALargeDisk) {
    for (const double size : decades(1, 1000)) {
        for (const double stride : {0.5, 3.0, 50.0}) { // of the large one's radii
            const double small = 1 / size, speed = 1000, h = stride / speed;
            SceneBuilder b(0, 0);
            b.gravity(0, 0).grain(small, {0, 0}, {speed, 0}).grain(1, {1.5 + small + 2 * stride, 0});
            allow(b, stride, 1);
            b.stage(solver(h, 50));
            SerialRun run(b.scene());
            const Vec<2> before = momentum(run);
            run.steps(10);
            EXPECT_LT(run.grain(0).x[0] + small, run.grain(1).x[0] - 1 + 1e-9) << size << ", " << stride;
            EXPECT_NEAR((momentum(run) - before).norm(), 0, 1e-9 * before.norm()) << size << ", " << stride;
        }
    }
}

/// A step looks at the tangent of a disk, not at the disk: at several radii a step, a miss is taken for a hit. Found: the
/// largest share of its speed that a disk loses to one that it passes, over all phases within a step.
TEST(Speeds, NearMiss) {
    for (const double miss : {1.01, 1.1, 1.5}) { // distance of the passing centres over 2 r
        for (const double stride : {0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0}) {
            double lost = 0;
            for (int phase = 0; phase < 20; ++phase) {
                const double speed = 1000, h = stride * r / speed;
                SceneBuilder b(0, 0);
                b.gravity(0, 0).grain(r, {-3 - stride * r * phase / 20.0, 0}, {speed, 0}).grain(r, {0, 2 * r * miss});
                allow(b, stride * r, r);
                b.stage(solver(h, 50));
                SerialRun run(b.scene());
                run.steps(static_cast<std::int64_t>(20 / stride) + 5);
                lost = std::max(lost, 1 - run.grain(0).v[0] / speed);
            }
            found("near miss", miss, stride, digits(lost));
            if (stride <= 0.25) {
                EXPECT_EQ(lost, 0) << miss << ", " << stride;
            }
        }
    }
}

/// Faster than tiles can follow: refused.
TEST(Speeds, FartherThanTilesAllow) {
    for (const double speed : decades(1, 1e9)) {
        SceneBuilder b(0, 0);
        b.gravity(0, 0).grain(r, {0, 0}, {speed, 0}).stage(solver(0.01, 10));
        SerialRun run(b.scene());
        const auto said = run_or_refusal(run, 100);
        EXPECT_EQ(said.find("farther than tiles allow") != std::string::npos, 1.5 * speed * 0.01 > 2.999 * r)
            << speed << said;
        EXPECT_TRUE(!said.empty() || std::abs(run.grain(0).x[0] - speed) < 1e-9 * speed) << speed;
    }
}

} // namespace
} // namespace nappe::test
