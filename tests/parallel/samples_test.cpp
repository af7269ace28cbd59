// Stored samples come back bit for bit on any number of ranks, or not at all.
#include "io/id_blocks.hpp"
#include "io/stored_manifest.hpp"
#include "io/sample_store.hpp"
#include "parallel/made_up_frame.hpp"
#include "parallel/shared_folder.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <limits>

namespace nappe {
namespace {

constexpr GlobalId n = 1001;
const SampleOrigin origin{3, "radius = 0.42 … 0.56\nseed = 1\n"};

/// Values that a detour over text or over arithmetic would lose.
GrainRow<2> awkward_grain(GlobalId id) {
    auto g = test::made_up_grain(id);
    g.v[1] = -0.0;
    g.rotation[0] = id % 2 ? std::numeric_limits<double>::denorm_min() : 0.1 + 0.2;
    return g;
}

void store(const Communicator& comm, const std::filesystem::path& folder, GlobalId n_grains = n) {
    std::vector<GrainRow<2>> grains;
    std::vector<ContactRow<2>> contacts;
    for (const GlobalId id : test::dealt_ids(comm, n_grains)) {
        grains.push_back(awkward_grain(id));
        const auto rows = test::made_up_contacts(id, n_grains);
        contacts.insert(contacts.end(), rows.begin(), rows.end());
    }
    store_sample<2>(comm, folder, origin, grains, contacts, {{"steps", 1234}});
}

bool same_bits(double a, double b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

void expect_block(const Communicator& comm, const StoredSample<2>& sample, GlobalId n_grains) {
    const IdBlocks blocks{n_grains, comm.size()};
    EXPECT_EQ(sample.n_grains, n_grains);
    ASSERT_EQ(static_cast<std::int64_t>(sample.grains.size()), blocks.count(comm.rank()));
    std::size_t c = 0;
    for (std::size_t i = 0; i < sample.grains.size(); ++i) {
        const auto& g = sample.grains[i];
        const auto expected = awkward_grain(blocks.first(comm.rank()) + static_cast<GlobalId>(i));
        ASSERT_EQ(g.id, expected.id);
        ASSERT_TRUE(same_bits(g.x[0], expected.x[0]) && same_bits(g.x[1], expected.x[1]));
        ASSERT_TRUE(same_bits(g.v[0], expected.v[0]) && same_bits(g.v[1], expected.v[1]));
        ASSERT_TRUE(same_bits(g.spin[0], expected.spin[0]) && same_bits(g.rotation[0], expected.rotation[0]));
        ASSERT_TRUE(same_bits(g.radius, expected.radius) && same_bits(g.mass, expected.mass));
        ASSERT_EQ(g.cells, expected.cells);
        ASSERT_EQ(g.material, expected.material);
        ASSERT_EQ(g.layer, expected.layer);
        auto rows = test::made_up_contacts(g.id, n_grains);
        std::sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.hi < b.hi; });
        for (const auto& row : rows) {
            ASSERT_LT(c, sample.contacts.size());
            ASSERT_EQ(sample.contacts[c].lo, row.lo);
            ASSERT_EQ(sample.contacts[c].hi, row.hi);
            ASSERT_TRUE(same_bits(sample.contacts[c].r_n, row.r_n) && same_bits(sample.contacts[c].r_t[0], row.r_t[0]));
            ++c;
        }
    }
    EXPECT_EQ(c, sample.contacts.size());
}

TEST(Samples, ComeBackBitForBit) {
    const Communicator world(MPI_COMM_WORLD);
    const test::SharedFolder folder(world);
    for (const GlobalId n_grains : {GlobalId{0}, GlobalId{1}, n}) {
        store(world, folder.path() / "samples", n_grains);
        const auto found = load_sample<2>(world, folder.path() / "samples", origin);
        ASSERT_TRUE(found.sample) << found.reason;
        expect_block(world, *found.sample, n_grains);
        EXPECT_EQ(found.sample->notes.at("steps"), 1234);
    }
}

TEST(Samples, StoredByOneRankAreReadByAllAndTheOtherWayRound) {
    const Communicator world(MPI_COMM_WORLD);
    const Communicator alone(MPI_COMM_SELF);
    const test::SharedFolder folder(world);
    if (world.is_root()) {
        store(alone, folder.path() / "alone");
    }
    world.barrier();
    store(world, folder.path() / "together");
    const auto found = load_sample<2>(world, folder.path() / "alone", origin);
    ASSERT_TRUE(found.sample) << found.reason;
    expect_block(world, *found.sample, n);
    const auto found_alone = load_sample<2>(alone, folder.path() / "together", origin);
    ASSERT_TRUE(found_alone.sample) << found_alone.reason;
    expect_block(alone, *found_alone.sample, n);
}

TEST(Samples, OfAnotherOriginAreNotFound) {
    const Communicator world(MPI_COMM_WORLD);
    const test::SharedFolder folder(world);
    store(world, folder.path());
    auto other = origin;
    other.physics_revision = 4;
    EXPECT_NE(other.key(), origin.key());
    EXPECT_FALSE(load_sample<2>(world, folder.path(), other).sample);
    // Nor under this one's name, and not even with a manifest of this one's key: two texts of one checksum would meet
    // so.
    const auto json_path = sample_path(folder.path(), other).replace_extension(".json");
    if (world.is_root()) {
        const auto from = sample_path(folder.path(), origin);
        std::filesystem::rename(from, sample_path(folder.path(), other));
        std::filesystem::rename(std::filesystem::path(from).replace_extension(".json"), json_path);
    }
    world.barrier();
    const auto renamed = load_sample<2>(world, folder.path(), other);
    EXPECT_FALSE(renamed.sample);
    EXPECT_NE(renamed.reason.find("manifest is of another sample"), std::string::npos) << renamed.reason;
    if (world.is_root()) {
        auto manifest = parse_manifest(read_text(json_path));
        manifest.key = other.key();
        std::ofstream(json_path) << format_manifest(manifest);
    }
    world.barrier();
    const auto forged = load_sample<2>(world, folder.path(), other);
    EXPECT_FALSE(forged.sample);
    EXPECT_NE(forged.reason.find("file is of another sample"), std::string::npos) << forged.reason;
}

/// Every damage must be found, on all ranks, with a reason; changing(path) does it on rank 0.
template <class Change>
std::string reason_after(const Communicator& world, Change change) {
    const test::SharedFolder folder(world);
    store(world, folder.path());
    EXPECT_TRUE(load_sample<2>(world, folder.path(), origin).sample);
    if (world.is_root()) {
        change(sample_path(folder.path(), origin));
    }
    world.barrier();
    const auto found = load_sample<2>(world, folder.path(), origin);
    EXPECT_FALSE(found.sample);
    return found.reason;
}

void flip(const std::filesystem::path& path, std::uintmax_t at) {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    char c = 0;
    file.seekg(static_cast<std::streamoff>(at)).get(c);
    file.seekp(static_cast<std::streamoff>(at)).put(static_cast<char>(c ^ 1));
}

TEST(Samples, OneFlippedBitAnywhereIsFound) {
    const Communicator world(MPI_COMM_WORLD);
    for (const double part : {0.0, 0.001, 0.1, 0.5, 0.999}) {
        const auto reason = reason_after(world, [&](const std::filesystem::path& path) {
            flip(path, static_cast<std::uintmax_t>(part * static_cast<double>(std::filesystem::file_size(path))));
        });
        EXPECT_NE(reason.find("is damaged"), std::string::npos) << reason;
    }
}

TEST(Samples, TruncatedFileIsFound) {
    const Communicator world(MPI_COMM_WORLD);
    const auto reason = reason_after(world, [](const std::filesystem::path& path) {
        std::filesystem::resize_file(path, std::filesystem::file_size(path) - 1);
    });
    EXPECT_NE(reason.find("bytes instead of"), std::string::npos) << reason;
}

TEST(Samples, MissingFileOrManifestIsFound) {
    const Communicator world(MPI_COMM_WORLD);
    const auto no_file = reason_after(world, [](const std::filesystem::path& path) { std::filesystem::remove(path); });
    EXPECT_NE(no_file.find(".hdf is not there"), std::string::npos) << no_file;
    const auto no_manifest = reason_after(
        world, [](std::filesystem::path path) { std::filesystem::remove(path.replace_extension(".json")); });
    EXPECT_NE(no_manifest.find(".json is not there"), std::string::npos) << no_manifest;
}

TEST(Samples, DamagedManifestIsFound) {
    const Communicator world(MPI_COMM_WORLD);
    const auto reason = reason_after(world, [](std::filesystem::path path) {
        path.replace_extension(".json");
        std::string text;
        std::getline(std::ifstream(path), text, '\0');
        flip(path, text.find("1234") + 3); // 1235 steps, in the notes: only the checksum sees it
    });
    EXPECT_NE(reason.find("manifest is damaged"), std::string::npos) << reason;
}

} // namespace
} // namespace nappe
