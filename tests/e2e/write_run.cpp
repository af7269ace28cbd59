// Writes the files of a small made-up run into a folder, for the scripts beside it to read: three frames, the middle
// one without contacts, and their indices. Usage: write_run DIR
#include "io/xdmf_index.hpp"
#include "parallel/made_up_frame.hpp"

#include <cstdio>

int main(int argc, char** argv) {
    nappe::MpiSession mpi(argc, argv);
    const nappe::Communicator world(MPI_COMM_WORLD);
    if (argc != 2) {
        std::fprintf(stderr, "usage: write_run DIR\n");
        return 2;
    }
    const std::filesystem::path folder = argv[1];
    if (world.is_root()) {
        std::filesystem::remove_all(folder);
        std::filesystem::create_directories(folder / "frames");
    }
    world.barrier();
    nappe::XdmfIndex index(folder, 2);
    for (const int k : {0, 1, 2}) {
        auto frame = nappe::test::made_up_frame(world, 100 + 10 * k, k != 1);
        frame.step = 250 * k;
        frame.time = 6.25 * k;
        const double time = frame.time;
        const auto file = nappe::frame_name(frame.step);
        const auto counts = nappe::write_frame<2>(world, folder / file, std::move(frame));
        index.add(world, {time, file, counts.n_grains, counts.n_contacts});
    }
    return 0;
}
