// Stored files that are whole by every checksum and yet can not be: each is refused with a reason, the same on all ranks,
// before room is made for what it claims; and HDF5 says nothing by itself.
#include "fuzz/message_rules.hpp"
#include "fuzz/stored_edits.hpp"
#include "io/checkpoint_store.hpp"
#include "io/checksum.hpp"
#include "io/hdf5_reader.hpp"
#include "io/row_rules.hpp"
#include "io/sample_store.hpp"
#include "io/scene_reader.hpp"
#include "io/stored_manifest.hpp"
#include "io/summary.hpp"
#include "parallel/made_up_frame.hpp"
#include "parallel/shared_folder.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <memory>

namespace nappe::stored_test {
namespace {

using fuzz::Table;

constexpr GlobalId n = 31;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
const SampleOrigin origin{3, "radius = 0.42 … 0.56\n"};

constexpr const char* scene_text = R"(
materials.rock.density = 2800
laws = [{ between = ["rock", "rock"], type = "frictional", friction = 0 },
        { between = ["rock", "wall"], type = "frictional", friction = 0 }]
sample = { material = "rock", radius = { law = "uniform", min = 0.42, max = 0.56 }, profile = [[0,0],[9,0],[9,9],[0,9]] }
walls = [{ name = "stairs", points = [[-1,0],[-1,1],[-2,1],[-2,2],[-3,2],[-3,3],[-4,3],[-4,4],[-5,4],[-5,5],[-6,5],[-6,6],
                                      [-7,6],[-7,7],[-8,7],[-8,8]] }]
stages = [{ name = "settle", until = {} }, { name = "push", duration = 1 }]
solver.h = 0.1)"; // 16 points and 15 segments: 62 faces

using Change = std::function<void(const std::filesystem::path&)>;

/// Change on one dataset, with all checksums put right.
Change table(const char* dataset, const std::function<void(Table&)>& change) {
    return [=](const std::filesystem::path& path) {
        fuzz::change_table(path, dataset, change);
        std::ifstream in(manifest_path(path));
        auto manifest = parse_manifest({std::istreambuf_iterator<char>(in), {}});
        manifest.file_bytes = std::filesystem::file_size(path);
        manifest.file_checksum = file_checksum(Communicator(MPI_COMM_SELF), path);
        std::ofstream(manifest_path(path)) << format_manifest(manifest);
    };
}

template <class T>
Change element(const char* dataset, std::size_t at, T value) {
    return table(dataset, [=](Table& t) { t.set(at, value); });
}

/// Change of the manifest's values, with its own checksum put right.
Change manifest(const std::function<void(nlohmann::ordered_json&)>& change) {
    return [=](const std::filesystem::path& path) {
        std::ifstream in(manifest_path(path));
        auto json = nlohmann::ordered_json::parse(in);
        json.erase("manifest_checksum");
        change(json);
        json["manifest_checksum"] = hex_digits(checksum(format_summary(json)));
        std::ofstream(manifest_path(path)) << format_summary(json);
    };
}

struct Case {
    const char* name;
    Change change;
    const char* reason; ///< part of it
};

/// What samples and checkpoints have alike.
std::vector<Case> common_cases() {
    return {
        {"id twice", element<std::int64_t>("/grains/id", 7, 6),
         "grains must be there once each, by id: found 6 where 7"},
        {"id out of range", element<std::int64_t>("/grains/id", 30, 1LL << 40), "found 1099511627776 where 30"},
        {"place", element("/grains/position", 9, nan), "grain 4: its position must be finite numbers, found ["},
        {"place beyond the world", element("/grains/position", 9, 1e300),
         "grain 4: its position must lie in the world"},
        {"velocity", element("/grains/velocity", 0, -std::numeric_limits<double>::infinity()),
         "grain 0: its velocity must be finite numbers, found [-inf"},
        {"radius", element("/grains/radius", 3, -0.5), "grain 3: its radius must lie in [0.41"},
        {"radius of another scene", element("/grains/radius", 3, 5.0), "grain 3: its radius must lie in [0.41"},
        {"mass", element("/grains/mass", 3, 0.0), "grain 3: its mass must be > 0 kg, found 0"},
        {"material", element<std::int32_t>("/grains/material", 3, 2),
         "grain 3: its material must be one of 2, found number 2"},
        {"partner", element<std::int64_t>("/contacts/hi", 1, 31),
         "contact (0, 31): its partner must be a later grain of 31"},
        {"face", element<std::int64_t>("/contacts/hi", 0, wall_key + 62), "or one of 62 faces of walls"},
        {"order", element<std::int64_t>("/contacts/hi", 1, 1), "contact (0, 1) must come after (0, 1)"},
        {"impulse", element("/contacts/r_n", 2, nan), "its impulses must be finite numbers, found nan"},
        {"offsets that fall", element<std::int64_t>("/grains/first_contact", 5, 1LL << 40),
         "must ascend from 0 to 41, found"},
        {"offsets below", element<std::int64_t>("/grains/first_contact", 0, -5), "must ascend from 0 to 41, found -5"},
        {"type", table("/grains/mass", [](Table& t) { t.type = H5T_NATIVE_INT64; }),
         "/grains/mass has another type or size"},
        {"columns", table("/grains/position", [](Table& t) { t.size = {62}; }),
         "/grains/position has another type or size"},
        {"fewer rows", table("/grains/mass", [](Table& t) { t.size = {30}; }), "/grains/mass has another type or size"},
        {"more rows",
         table("/grains/mass",
               [](Table& t) {
                   t.size = {32};
                   t.bytes.resize(32 * sizeof(double));
               }),
         "/grains/mass is damaged"},
        {"fewer grains", table("/grains/id", [](Table& t) { t.size = {30}; }),
         "/grains/id has 30 rows, the manifest says 31"},
        {"no layers",
         table("/grains/mass",
               [](Table& t) {
                   t.size = {0, 31, 1};
                   t.bytes.clear();
               }),
         "/grains/mass is an image without layers"},
        {"a claim",
         table("/grains/mass",
               [](Table& t) {
                   t.size = {1ULL << 40};
                   t.hollow = true;
               }),
         "/grains/mass claims more rows than are stored"},
        {"checksum", table("/grains/mass", [](Table& t) { t.wrong_checksum = true; }), "/grains/mass is damaged"},
        {"no HDF5",
         [](const std::filesystem::path& path) {
             std::ofstream(path) << "not HDF5 at all, though its checksum is right";
             manifest([&](auto& json) {
                 json["file_bytes"] = std::filesystem::file_size(path);
                 json["file_checksum"] = hex_digits(file_checksum(Communicator(MPI_COMM_SELF), path));
                 json["n_grains"] = json["n_contacts"] = 0;
             })(path);
         },
         "the file can not be opened"},
        {"rows of 2^40", manifest([](auto& json) { json["n_grains"] = 1LL << 40; }),
         "n_grains and n_contacts must be no more than a file of its file_bytes can hold"},
        {"rows of 2^64", manifest([](auto& json) { json["n_contacts"] = ~0ULL; }),
         "n_contacts must be a whole number >= 0"},
        {"negative rows", manifest([](auto& json) { json["n_grains"] = -1; }), "n_grains must be a whole number >= 0"},
        {"a count in words", manifest([](auto& json) { json["file_bytes"] = "many"; }),
         "file_bytes must be a whole number"},
        {"no key", manifest([](auto& json) { json.erase("key"); }), "key must be 16 hexadecimal digits"},
        {"a checksum of another kind", manifest([](auto& json) { json["file_checksum"] = "-1"; }),
         "file_checksum must be 16"},
        {"notes", manifest([](auto& json) { json["notes"] = 3; }), "notes must be a table"},
        {"another version", manifest([](auto& json) { json["format"] = 99; }), "is of another version of nappe"},
        {"no version", manifest([](auto& json) { json.erase("format"); }), "is of another version of nappe"},
        {"nested without end",
         [](const std::filesystem::path& path) { std::ofstream(manifest_path(path)) << std::string(1 << 20, '['); },
         "the manifest is damaged"},
        {"endless",
         [](const std::filesystem::path& path) {
             std::ofstream(manifest_path(path)) << std::string((16 << 20) + 1, ' ');
         },
         "is longer than any manifest, 16 MiB"},
        {"cut",
         [](const std::filesystem::path& path) {
             std::filesystem::resize_file(path, std::filesystem::file_size(path) - 1);
         },
         "bytes instead of"},
        {"grown", [](const std::filesystem::path& path) { std::ofstream(path, std::ios::app) << ' '; },
         "bytes instead of"},
        {"a byte",
         [](const std::filesystem::path& path) {
             std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
             file.seekp(0).put('!');
         },
         "is damaged"},
    };
}

std::vector<Case> checkpoint_cases() {
    auto cases = common_cases();
    const std::vector<Case> own = {
        {"place at the last rebuild", element("/grains/reference", 9, nan),
         "grain 4: its position at the last rebuild"},
        {"margin", element("/grains/margin", 2, nan), "grain 2: its margin must be finite"},
        {"wall", element("/walls/v", 1, nan), "wall stairs: its velocity must be finite numbers"},
        {"a wall too many",
         table("/walls/margin",
               [](Table& t) {
                   t.size = {2};
                   t.bytes.resize(2 * sizeof(double));
               }),
         "dataset /walls/"},
        {"another scene", table("/scene", [](Table& t) { t.bytes[1] = std::byte{'#'}; }), "its scene"},
        {"no scene", table("/scene", [](Table& t) { t.bytes.assign(t.bytes.size(), std::byte{0xff}); }),
         "its scene:1: must be"},
        {"no clock", table("/clock", [](Table& t) { t.bytes.assign(t.bytes.size(), std::byte{'['}); }),
         "must give stage as"},
        {"no course", table("/course", [](Table& t) { t.bytes.assign(t.bytes.size(), std::byte{'1'}); }),
         "must be a table"},
        {"owner", element<std::int64_t>("/tiles/rank", 1, -1), "owners of tiles must be ranks, found -1"},
        {"no number of ranks", manifest([](auto& json) { json["notes"].erase("ranks"); }),
         "must give the number of ranks"},
        {"another physics", manifest([](auto& json) { json["physics_revision"] = 1; }),
         "go on with the program that wrote it"},
        {"another physics of no name", manifest([](auto& json) {
             json["physics_revision"] = 1;
             json["notes"]["version"] = 7;
         }),
         "is of nappe ?, physics 1"},
    };
    cases.insert(cases.end(), own.begin(), own.end());
    return cases;
}

/// This rank's share: all on the root, the simplest way to deal them.
template <class Row, class Make>
std::vector<Row> dealt(const Communicator& comm, Make make) {
    std::vector<Row> rows;
    for (GlobalId id = 0; comm.is_root() && id < n; ++id) {
        make(rows, id);
    }
    return rows;
}

std::vector<ContactRow<2>> contacts(const Communicator& comm) {
    return dealt<ContactRow<2>>(comm, [](auto& rows, GlobalId id) {
        const auto some = test::made_up_contacts(id, n);
        rows.insert(rows.end(), some.begin(), some.end());
    });
}

std::filesystem::path store(const Communicator& comm, const std::filesystem::path& folder, bool checkpoint) {
    if (!checkpoint) {
        const auto grains =
            dealt<GrainRow<2>>(comm, [](auto& rows, GlobalId id) { rows.push_back(test::made_up_grain(id)); });
        store_sample<2>(comm, folder, origin, grains, contacts(comm), {{"steps", 1}});
        return sample_path(folder, origin);
    }
    Checkpoint<2> made{
        .serial = 1, .key = 7, .ranks = 1, .scene = scene_text, .snapshot = {}, .course = {}, .notes = {}};
    made.course["cells"] = nlohmann::ordered_json::array();
    made.notes["step"] = 3;
    made.snapshot.grains = dealt<SnapshotGrain<2>>(comm, [](auto& rows, GlobalId id) {
        const auto g = test::made_up_grain(id);
        rows.push_back({g.id, g.x, g.x, g.v, g.spin, g.rotation, g.radius, g.mass, 0.1, g.cells, g.material, g.layer});
    });
    made.snapshot.impulses = contacts(comm);
    made.snapshot.clock.stage = 1;
    made.snapshot.walls.resize(1);
    made.snapshot.sums.assign(12, 1);
    made.snapshot.owners = {{5, 0}, {6, 0}};
    store_checkpoint(comm, folder, made);
    return checkpoint_path(folder, 1);
}

/// Why the file is not used; "" if it is.
std::string load(const Communicator& comm, const std::filesystem::path& folder, bool checkpoint) {
    if (checkpoint) {
        const auto found = load_newest_checkpoint<2>(comm, folder);
        return found.checkpoint ? "" : found.blocked.empty() ? found.reasons.at(0) : found.blocked;
    }
    const auto limits = row_limits(parse_scene(scene_text, "scene"));
    const auto found = load_sample<2>(comm, folder, origin, limits);
    return found.sample ? "" : found.reason;
}

void expect_reasons(const std::vector<Case>& cases, bool checkpoint) {
    const Communicator world(MPI_COMM_WORLD);
    for (const auto& c : cases) {
        const test::SharedFolder folder(world);
        const auto path = store(world, folder.path(), checkpoint);
        ASSERT_EQ(load(world, folder.path(), checkpoint), "") << c.name;
        if (world.is_root()) {
            c.change(path);
        }
        world.barrier();
        testing::internal::CaptureStderr();
        const auto reason = load(world, folder.path(), checkpoint);
        EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << c.name << ": HDF5 speaks for itself";
        EXPECT_NE(reason.find(c.reason), std::string::npos) << c.name << ": " << reason;
        EXPECT_EQ(fuzz::fault_of_text(reason, ""), "") << c.name << ": " << reason;
        std::string of_root = reason;
        world.broadcast(of_root);
        EXPECT_EQ(reason, of_root) << c.name;
    }
}

TEST(Stored, SamplesThatCanNotBeAreRefused) {
    expect_reasons(common_cases(), false);
}

TEST(Stored, CheckpointsThatCanNotBeAreRefused) {
    expect_reasons(checkpoint_cases(), true);
}

/// Of two readers, the one that goes first must not let HDF5 speak again.
TEST(Stored, TwoReadersAreSilent) {
    const Communicator world(MPI_COMM_WORLD);
    const test::SharedFolder folder(world);
    const auto path = store(world, folder.path(), false);
    testing::internal::CaptureStderr();
    auto first = std::make_unique<Hdf5Reader>(path);
    const Hdf5Reader second(path);
    first.reset();
    EXPECT_THROW(second.integer("/", "nothing"), Hdf5Failure);
    EXPECT_THROW(second.rows("/nothing"), Hdf5Failure);
    EXPECT_THROW(Hdf5Reader("/nothing"), Hdf5Failure);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

/// Of a text that is several, only as many bytes as one has room for may arrive.
TEST(Stored, AttributeOfSeveralTextsIsRefused) {
    const Communicator world(MPI_COMM_WORLD);
    const test::SharedFolder folder(world);
    const auto path = store(world, folder.path(), false);
    if (world.is_root()) {
        const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose, "open");
        const hsize_t many = 1000;
        const Hdf5Handle space(H5Screate_simple(1, &many, nullptr), H5Sclose, "space");
        const Hdf5Handle texts(H5Acreate2(file.get(), "texts", H5T_C_S1, space.get(), H5P_DEFAULT, H5P_DEFAULT),
                               H5Aclose, "texts");
        const std::string letters(many, 'x');
        H5Awrite(texts.get(), H5T_C_S1, letters.data());
    }
    world.barrier();
    EXPECT_THROW(Hdf5Reader(path).text("/", "texts"), Hdf5Failure);
}

} // namespace
} // namespace nappe::stored_test
