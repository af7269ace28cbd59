// A plate that leaves its neighbour along a fault, with a face that comes out behind its edge (scenes.md §2, the fault
// scene): no grain slips beneath it or through the joint, none is caught at the edge.

#include "support/serial_run.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace nappe::test::fault_plate_test {
namespace {

constexpr double r_min = 0.13, r_max = 0.26, speed = 0.325, angle = std::numbers::pi / 6;
const Vec<2> along(std::cos(angle), std::sin(angle));

/// Two plates that meet in (tip, 0); the left one and its end wall move along the fault from the start of stage 0.
SceneBuilder plates(double tip, double length, double friction) {
    SceneBuilder scene(friction);
    scene.moving_wall("hanging", {{0, 20}, {0, 0}, {tip, 0}, Vec<2>(tip, 0) - 8 * along}, {speed * along, 0, 0, {}});
    scene.wall("footwall", {{tip, 0}, {length, 0}, {length, 20}});
    return scene;
}

double distance_to_ray(const Vec<2>& x, const Vec<2>& start, const Vec<2>& direction) {
    return (x - start - std::max(0.0, (x - start).dot(direction)) * direction).norm();
}

/// Distance of a centre from the block above the fault and the ground below the footwall [m]; negative: inside.
double distance(const Vec<2>& x, double tip, double slip) {
    const Vec<2> edge = Vec<2>(tip, 0) + slip * along;
    const Vec<2> from_edge = x - edge;
    const bool inside = from_edge[1] < 0 && from_edge[0] * along[1] - from_edge[1] * along[0] < 0; // left of the fault
    const double to_block = std::min(distance_to_ray(x, edge, {-1, 0}), distance_to_ray(x, edge, -along));
    return std::min(inside ? -to_block : to_block, x[0] > tip ? x[1] : 1.0);
}

TEST(FaultPlate, NoGrainGetsIntoTheBlockOrThroughTheJoint) {
    for (const double gamma : {0.0, 1e4}) {
        SceneBuilder scene = plates(8, 16, 0.4);
        Sample<2> sample;
        sample.radii = {RadiusLaw::Kind::uniform, r_min, r_max};
        sample.profile = {{0, 0}, {16, 0}, {16, 3}, {0, 3}};
        scene.scene().sample = sample;
        scene.cohesion(0, 0, gamma, 0.01);
        scene.stage(solver(0.01, 60));
        SerialRun run(scene.scene());
        for (int look = 1; look <= 10; ++look) {
            run.steps(120);
            const double slip = run.simulation().walls().offset[0].norm();
            EXPECT_NEAR(slip, speed * 0.01 * (120 * look - 0.5), 1e-9); // theta = 1/2: the first step moves half
            for (const auto& grain : run.simulation().grain_rows()) {
                // A grain that touches is at its radius outside; half of that leaves room for overlaps of 60 sweeps.
                EXPECT_GT(distance({grain.x[0], grain.x[1]}, 8, slip), 0.5 * grain.radius)
                    << "grain " << grain.id << " at " << grain.x[0] << ", " << grain.x[1] << " after a slip of "
                    << slip;
            }
            EXPECT_LT(overlaps(run.simulation()).largest, 0.5);
        }
    }
}

TEST(FaultPlate, AFaceThatSlidesAlongItselfPushesNothing) {
    // In the wedge between the face, which is a metre out, and the footwall, without friction and weightless: nothing happens
    // to a grain that touches both. The wedge opens by 30 degrees from the tip, so its centre is r / tan(15°) along.
    SceneBuilder scene(0.0);
    const Vec<2> tip(8, 0);
    scene.moving_wall("hanging", {{0, 20}, {0, along[1]}, tip + along, tip - 8 * along}, {speed * along, 0, 0, {}});
    scene.wall("footwall", {tip, {16, 0}, {16, 20}});
    scene.gravity(0, 0).grain(0.2, {8 + 0.2 / std::tan(angle / 2), 0.2}).stage(solver(0.01, 50));
    SerialRun run(scene.scene());
    run.steps(600);
    EXPECT_NEAR(run.grain(0).x[0], 8 + 0.2 / std::tan(angle / 2), 1e-9);
    EXPECT_NEAR(run.grain(0).x[1], 0.2, 1e-9);
}

TEST(FaultPlate, AGrainAtTheEdgeIsNotCaught) {
    // One grain on the joint, as light as you like: the edge lifts it and pushes it on until it rolls back onto the plate or
    // off it; whatever it does, it comes to rest on one of the two, with no overlap and nothing between it and its floor.
    for (const double x : {7.8, 7.9, 8.0, 8.1, 8.2, 8.3}) {
        for (const double friction : {0.0, 0.4}) {
            SceneBuilder scene = plates(8, 30, friction);
            scene.grain(0.2, {x, 0.2}).stage(solver(0.01, 50));
            SerialRun run(scene.scene());
            run.steps(1000);
            const double slip = run.simulation().walls().offset[0].norm();
            const auto grain = run.grain(0);
            const double plate = slip * along[1];
            const bool on_plate = grain.x[0] < 8 + slip * along[0] && grain.x[1] > plate;
            EXPECT_NEAR(grain.x[1], on_plate ? plate + 0.2 : 0.2, 0.05) << "from " << x << ", friction " << friction;
            EXPECT_LT(overlaps(run.simulation()).largest, 0.05);
            if (!on_plate) {
                EXPECT_GT(grain.x[0], 8.0);
            }
        }
    }
}

} // namespace
} // namespace nappe::test::fault_plate_test
