// Writes the flow's measures of two made-up frames into a folder, for read_fields.py: a square of disks in simple shear
// at 0.1 per second, ten seconds apart. Usage: write_fields DIR
#include "commands/flow_measurer.hpp"

#include <cstdio>
#include <numbers>

int main(int argc, char** argv) {
    nappe::MpiSession mpi(argc, argv);
    const nappe::Communicator world(MPI_COMM_WORLD);
    if (argc != 2) {
        std::fprintf(stderr, "usage: write_fields DIR\n");
        return 2;
    }
    constexpr nappe::GlobalId side = 30;
    const nappe::IdBlocks blocks{side * side, world.size()};
    const nappe::Scene<2> scene;
    nappe::FlowMeasurer measurer(world, scene, argv[1]);
    for (const int k : {0, 1}) {
        std::vector<nappe::FrameGrain<2>> block;
        for (auto id = blocks.first(world.rank()); id < blocks.first(world.rank() + 1); ++id) {
            nappe::FrameGrain<2> row;
            const auto y = static_cast<double>(id / side);
            row.grain.id = id;
            row.grain.x = {static_cast<double>(id % side) + k * y, y};
            row.grain.radius = 0.5;
            row.grain.mass = std::numbers::pi / 4;
            row.grain.layer = 1;
            block.push_back(row);
        }
        measurer.measure(100 * k, 10.0 * k, block, {});
    }
    measurer.finish();
    return 0;
}
