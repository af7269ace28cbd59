// Frames hold the same bytes on any number of ranks, and are whole or not there.
#include "core/error.hpp"
#include "io/atomic_file.hpp"
#include "io/hdf5_reader.hpp"
#include "parallel/made_up_frame.hpp"
#include "parallel/shared_folder.hpp"
#include "unit/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <unistd.h>

namespace nappe {
namespace {

using test::made_up_frame;
using test::SharedFolder;

std::size_t n_files(const std::filesystem::path& folder) {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(Frames, HoldEveryRowInTheOrderOfIds) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    const GlobalId n = 1001;
    const auto path = folder.path() / "frame.hdf";
    const auto counts = write_frame<2>(world, path, made_up_frame(world, n));
    EXPECT_EQ(counts.n_grains, n);
    EXPECT_EQ(counts.n_contacts, 334 + 1000);

    const Hdf5Reader file(path);
    const auto id = file.read<std::int64_t>("/VTKHDF/PointData/id");
    const auto x = file.read<double>("/VTKHDF/Points", 0, n, 3);
    const auto radius = file.read<double>("/VTKHDF/PointData/radius");
    const auto cells = file.read<std::uint64_t>("/VTKHDF/PointData/cells");
    const auto offsets = file.read<std::int64_t>("/VTKHDF/Offsets");
    ASSERT_EQ(id.size(), static_cast<std::size_t>(n));
    ASSERT_EQ(offsets.size(), static_cast<std::size_t>(n + 1));
    EXPECT_EQ(offsets.back(), n);
    std::size_t c = 0;
    const auto lo = file.read<std::int64_t>("/contacts/lo");
    const auto hi = file.read<std::int64_t>("/contacts/hi");
    const auto r_t = file.read<double>("/contacts/r_t");
    ASSERT_EQ(lo.size(), 1334u);
    for (GlobalId i = 0; i < n; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const auto expected = test::made_up_grain(i);
        ASSERT_EQ(id[at], i);
        ASSERT_EQ(x[3 * at], expected.x[0]);
        ASSERT_EQ(x[3 * at + 1], expected.x[1]);
        ASSERT_EQ(x[3 * at + 2], 0.0);
        ASSERT_EQ(radius[at], expected.radius);
        ASSERT_EQ(cells[at], expected.cells);
        auto rows = test::made_up_contacts(i, n);
        std::sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.hi < b.hi; });
        for (const auto& row : rows) {
            ASSERT_EQ(lo[c], row.lo);
            ASSERT_EQ(hi[c], row.hi);
            ASSERT_EQ(r_t[c], row.r_t[0]);
            ++c;
        }
    }
    EXPECT_EQ(file.integer("/", "step"), 250);
    EXPECT_EQ(file.number("/", "time"), 6.25);
    EXPECT_EQ(file.text("/", "title"), "a fold, made up — in UTF-8");
    EXPECT_EQ(file.text("/VTKHDF", "Type"), "UnstructuredGrid");
    EXPECT_EQ(file.rows("/walls/floor"), 3);
    EXPECT_EQ(file.integer("/walls/left_wall", "index"), 1);
    EXPECT_EQ(n_files(folder.path()), 1u) << "a temporary file is left";
}

TEST(Frames, SayWhichRankOwnedAGrain) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    const auto path = folder.path() / "frame.hdf";
    write_frame<2>(world, path, made_up_frame(world, 50));
    const auto ranks = Hdf5Reader(path).read<std::int32_t>("/VTKHDF/PointData/rank");
    for (const GlobalId id : test::dealt_ids(world, 50)) {
        EXPECT_EQ(ranks[static_cast<std::size_t>(id)], world.rank());
    }
}

TEST(Frames, AreTheSameFileOnAnyNumberOfRanks) {
    const Communicator world(MPI_COMM_WORLD);
    const Communicator alone(MPI_COMM_SELF);
    const SharedFolder folder(world);
    for (const GlobalId n : {GlobalId{0}, GlobalId{1}, GlobalId{2}, GlobalId{777}}) {
        for (const bool with_contacts : {true, false}) {
            write_frame<2>(world, folder.path() / "together.hdf", made_up_frame(world, n, with_contacts, false));
            if (world.is_root()) {
                write_frame<2>(alone, folder.path() / "alone.hdf", made_up_frame(alone, n, with_contacts, false));
                EXPECT_TRUE(test::text_of(folder.path() / "together.hdf") == test::text_of(folder.path() / "alone.hdf"))
                    << n << " grains, contacts " << with_contacts;
            }
            world.barrier();
        }
    }
}

TEST(Frames, RefuseALostAndADoubledGrain) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    auto frame = made_up_frame(world, 20);
    for (auto& row : frame.grains) {
        if (row.grain.id == 7) {
            row.grain.id = 8;
        }
    }
    EXPECT_THROW(write_frame<2>(world, folder.path() / "frame.hdf", std::move(frame)), SystemError);
    EXPECT_EQ(n_files(folder.path()), 0u);
}

/// What all ranks throw, or a failure of the test.
std::string error_of_writing(const Communicator& world, const std::filesystem::path& path) {
    try {
        write_frame<2>(world, path, made_up_frame(world, 20));
    } catch (const SystemError& error) {
        return error.what();
    }
    ADD_FAILURE() << "written to " << path << " without an error";
    return {};
}

TEST(Frames, MissingFolderIsAnErrorOnAllRanks) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    const auto text = error_of_writing(world, folder.path() / "missing" / "frame.hdf");
    EXPECT_NE(text.find("missing/frame.hdf"), std::string::npos) << text;
    EXPECT_NE(text.find("create the folder first"), std::string::npos) << text;
}

TEST(Frames, ReadOnlyFolderIsAnErrorOnAllRanksAndTheOlderFrameStays) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    const auto path = folder.path() / "frame.hdf";
    write_frame<2>(world, path, made_up_frame(world, 5));
    const auto before = test::text_of(path);
    if (world.is_root()) {
        std::filesystem::permissions(folder.path(), std::filesystem::perms{0555});
    }
    world.barrier();
    const bool as_root = ::geteuid() == 0;
    if (as_root) { // whom permissions do not stop
        ASSERT_EQ(::seteuid(65534), 0);
    }
    const auto text = error_of_writing(world, path);
    if (as_root) {
        ASSERT_EQ(::seteuid(0), 0);
    }
    EXPECT_NE(text.find("choose a folder you may write to"), std::string::npos) << text;
    EXPECT_TRUE(test::text_of(path) == before);
    world.barrier();
    if (world.is_root()) {
        std::filesystem::permissions(folder.path(), std::filesystem::perms{0755});
    }
}

TEST(Frames, NameThatIsAFolderLeavesNoTemporaryFile) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    const auto path = folder.path() / "frame.hdf";
    if (world.is_root()) {
        std::filesystem::create_directories(path / "full");
    }
    world.barrier();
    const auto text = error_of_writing(world, path);
    EXPECT_NE(text.find("can not be given its name"), std::string::npos) << text;
    EXPECT_EQ(n_files(folder.path()), 1u) << "a temporary file is left";
}

} // namespace
} // namespace nappe
