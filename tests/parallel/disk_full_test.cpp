// A disk that fills up while a frame or a sample is written: every rank throws, nothing half-written is left, the older
// file stays, and the next one that fits is written.
//
// The disk is a small file system mounted by tests/parallel/with_small_disk (NAPPE_SMALL_DISK), or else a limit on the
// size of the files of the last rank alone, which is the harder case: only one rank sees the error.
#include "core/error.hpp"
#include "io/sample_store.hpp"
#include "parallel/made_up_frame.hpp"
#include "parallel/shared_folder.hpp"
#include "unit/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <optional>

namespace nappe {
namespace {

constexpr GlobalId n_fits = 100;
constexpr GlobalId n_too_many = 40'000; // 14 MB with its contacts

/// Files of the last rank can not grow beyond so many bytes while it lives; without effect if there is a small disk.
/// Open MPI makes a small file of its own whenever it opens one, and hangs if it can not: that much is left.
std::optional<test::FileSizeLimit> small_files(const Communicator& comm, int bytes) {
    if (comm.rank() != comm.size() - 1 || std::getenv("NAPPE_SMALL_DISK")) {
        return std::nullopt;
    }
    return std::optional<test::FileSizeLimit>(std::in_place, static_cast<rlim_t>(std::max(bytes, 4096)));
}

class DiskFull : public testing::TestWithParam<int> {
protected:
    DiskFull() : world(MPI_COMM_WORLD), folder(world, small_disk()) {}

    static std::filesystem::path small_disk() {
        const char* disk = std::getenv("NAPPE_SMALL_DISK");
        return disk ? disk : "";
    }

    /// Leaves about so many bytes on the small disk. Collective.
    void leave_free(std::uintmax_t bytes) {
        if (world.is_root() && !small_disk().empty()) {
            const auto free = std::filesystem::space(folder.path()).available;
            std::ofstream(folder.path() / "filler") << std::string(free > bytes ? free - bytes : 0, 'x');
        }
        world.barrier();
    }

    std::vector<std::string> files() const {
        std::vector<std::string> names;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path())) {
            if (entry.path().filename() != "filler") {
                names.push_back(entry.path().filename().string());
            }
        }
        std::sort(names.begin(), names.end());
        return names;
    }

    Communicator world;
    test::SharedFolder folder;
};

TEST_P(DiskFull, FrameThrowsOnAllRanksAndTheOlderOneStays) {
    const auto path = folder.path() / "frame.hdf";
    write_frame<2>(world, path, test::made_up_frame(world, n_fits));
    const auto before = test::text_of(path);
    leave_free(static_cast<std::uintmax_t>(GetParam()));
    std::string text;
    {
        const auto limit = small_files(world, GetParam());
        try {
            write_frame<2>(world, path, test::made_up_frame(world, n_too_many));
        } catch (const SystemError& error) {
            text = error.what();
        }
    }
    EXPECT_NE(text.find("frame.hdf"), std::string::npos) << "rank " << world.rank() << ": " << text;
    EXPECT_TRUE(test::text_of(path) == before);
    EXPECT_EQ(files(), std::vector<std::string>{"frame.hdf"});
    // The library is in order again: a frame that fits is written.
    world.barrier();
    if (world.is_root()) {
        std::filesystem::remove(folder.path() / "filler");
    }
    world.barrier();
    EXPECT_EQ(write_frame<2>(world, path, test::made_up_frame(world, n_fits + 1)).n_grains, n_fits + 1);
}

TEST_P(DiskFull, SampleThrowsOnAllRanks) {
    const SampleOrigin origin{1, "a sample that does not fit"};
    std::vector<GrainRow<2>> grains;
    for (const GlobalId id : test::dealt_ids(world, n_too_many)) {
        grains.push_back(test::made_up_grain(id));
    }
    leave_free(static_cast<std::uintmax_t>(GetParam()));
    {
        const auto limit = small_files(world, GetParam());
        EXPECT_THROW(store_sample<2>(world, folder.path() / "samples", origin, grains, {}, {}), SystemError);
    }
    EXPECT_FALSE(load_sample<2>(world, folder.path() / "samples", origin).sample);
    EXPECT_EQ(files(), std::vector<std::string>{"samples"});
}

// From no room for the first byte, over the middle of the datasets, to the last pages missing.
INSTANTIATE_TEST_SUITE_P(BytesFree, DiskFull, testing::Values(0, 1000, 5000, 100'000, 1'000'000, 2'000'000));

} // namespace
} // namespace nappe
