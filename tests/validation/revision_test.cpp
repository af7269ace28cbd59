// Stored samples are found again by a key that holds physics_revision: a change of a bit that does not count it up
// would let a run use a sample that the code no longer makes. The hash here is no measure of anything being right; it
// is the bits that go with the revision. If this test fails and the change was meant, count physics_revision up
// (src/io/stored_manifest.hpp) and put both here.
#include "commands/prepare.hpp"
#include "support/kernels.hpp"
#include "support/serial_run.hpp"

#include "io/stored_manifest.hpp"
#include <gtest/gtest.h>

namespace {

using namespace nappe;

TEST(Revision, BitsOfASampleGoWithIt) {
    Scene<2> scene;
    scene.gravity = Vec<2>(0, -9.81);
    scene.materials = {{"wall", 0.0}, {"rock", 2800.0}};
    scene.laws = {{1, 1, 0.4, 0.0}, {1, 0, 0.4, 0.0}};
    Sample<2> sample;
    sample.material = 1;
    sample.radii = {RadiusLaw::Kind::uniform, 0.42, 0.56};
    sample.profile = {{0, 0}, {30, 0}, {30, 6}, {10, 12}, {0, 12}};
    scene.sample = sample;
    scene.walls = {{"box", 0, {{0, 20}, {0, 0}, {30, 0}, {30, 20}}, {}}};
    Stage settle;
    settle.name = "settle";
    settle.until = SettleCriterion{};
    settle.solver.h = 0.025;
    scene.stages = {settle};

    EXPECT_EQ(physics_revision, 3);
    for (const char* kernel : test::kernels_here()) {
        test::SerialRun run(scene, kernel);
        run.steps(40);
        EXPECT_EQ(run.simulation().state_hash(), 0x819877c85f4b690eULL)
            << kernel << ": " << std::hex << run.simulation().state_hash();
    }
}

} // namespace
