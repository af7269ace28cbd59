// What stands between a stored file and a computation: load_sample and load_newest_checkpoint either return what a
// computation may start from, or say why not. A file that is not what its manifest says is refused before HDF5 opens it.
//
// An input: how to spoil a sound file (first byte modulo 4), sample or checkpoint, its number of grains, where to spoil it.
// Faults inside HDF5 behind a valid checksum are out of scope: HDF5 1.10.8 has them.
#include "fuzz/fuzz_target.hpp"
#include "fuzz/message_rules.hpp"
#include "fuzz/stored_edits.hpp"

#include "io/checkpoint_store.hpp"
#include "io/checksum.hpp"
#include "io/row_rules.hpp"
#include "io/sample_store.hpp"
#include "io/scene_reader.hpp"
#include "io/stored_manifest.hpp"
#include "io/summary.hpp"
#include "parallel/communicator.hpp"
#include "parallel/made_up_frame.hpp"

#include <unistd.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <set>

namespace {

using namespace nappe;
using fuzz::broken;
using fuzz::ByteSource;

const SampleOrigin origin{3, "radius = 0.42 … 0.57\n"};

/// 18 faces of walls, two materials, and the radii of made_up_grain.
constexpr const char* scene_text = R"(
materials.rock.density = 2800
laws = [{ between = ["rock", "rock"], type = "frictional", friction = 0 },
        { between = ["rock", "wall"], type = "frictional", friction = 0 }]
sample = { material = "rock", radius = { law = "uniform", min = 0.42, max = 0.57 }, profile = [[0,0],[9,0],[9,9],[0,9]] }
walls = [{ name = "bowl", points = [[-9, 9], [-9, 0], [-9, -9], [20, -9], [20, 9]] }]
stages = [{ name = "settle", until = {} }, { name = "push", duration = 1 }]
solver.h = 0.1)";
constexpr GlobalId n_faces = 18;

/// A sound file as it lies on disk.
struct Stored {
    std::filesystem::path path;
    std::string file;
    std::string manifest;
};

struct World {
    World(int argc, char** argv)
        : mpi(argc, argv),
          folder(std::filesystem::temp_directory_path() / ("nappe_fuzz_" + std::to_string(::getpid()))) {
        std::filesystem::create_directories(folder);
    }
    ~World() { std::filesystem::remove_all(folder); }

    MpiSession mpi;
    Communicator comm{MPI_COMM_SELF};
    std::filesystem::path folder;
    Scene<2> scene = parse_scene(scene_text, "scene");
    std::map<std::pair<bool, GlobalId>, Stored> sound; ///< by whether it is a checkpoint, and number of grains
};
std::unique_ptr<World> world;

void write(const std::filesystem::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

std::string read(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

Checkpoint<2> made_up_checkpoint(GlobalId n) {
    Checkpoint<2> checkpoint{.serial = 1,
                             .key = 7,
                             .ranks = 1,
                             .scene = scene_text,
                             .snapshot = {},
                             .course = {{"cells", nlohmann::ordered_json::array()}},
                             .notes = {{"stage", "push"}, {"step", 3}, {"time", 0.3}}};
    auto& snapshot = checkpoint.snapshot;
    snapshot.clock.stage = 1;
    snapshot.clock.impulse_h = 0.1;
    for (GlobalId id = 0; id < n; ++id) {
        const auto g = test::made_up_grain(id);
        snapshot.grains.push_back(
            {g.id, g.x, g.x, g.v, g.spin, g.rotation, g.radius, g.mass, 0.1, g.cells, g.material, g.layer});
        const auto rows = test::made_up_contacts(id, n);
        snapshot.impulses.insert(snapshot.impulses.end(), rows.begin(), rows.end());
    }
    snapshot.walls.resize(1);
    snapshot.sums.assign(12, 1);
    snapshot.owners = {{5, 0}, {6, 0}};
    return checkpoint;
}

const Stored& sound_file(bool checkpoint, GlobalId n) {
    auto& stored = world->sound[{checkpoint, n}];
    if (!stored.file.empty()) {
        return stored;
    }
    if (checkpoint) {
        store_checkpoint(world->comm, world->folder, made_up_checkpoint(n));
        stored.path = checkpoint_path(world->folder, 1);
    } else {
        std::vector<GrainRow<2>> grains;
        std::vector<ContactRow<2>> contacts;
        for (GlobalId id = 0; id < n; ++id) {
            grains.push_back(test::made_up_grain(id));
            const auto rows = test::made_up_contacts(id, n);
            contacts.insert(contacts.end(), rows.begin(), rows.end());
        }
        store_sample<2>(world->comm, world->folder, origin, grains, contacts, {{"settle_steps", 12}});
        stored.path = sample_path(world->folder, origin);
    }
    stored.file = read(stored.path);
    stored.manifest = read(manifest_path(stored.path));
    return stored;
}

/// The manifest of the file as it is now, with every checksum right.
StoredManifest manifest_of(const std::filesystem::path& path, const std::string& text) {
    auto manifest = parse_manifest(text);
    manifest.file_bytes = std::filesystem::file_size(path);
    manifest.file_checksum = file_checksum(world->comm, path);
    return manifest;
}

/// A value that a manifest should not have, with the manifest's own checksum right.
std::string forged_manifest(const std::string& text, ByteSource& bytes) {
    using Json = nlohmann::ordered_json;
    auto json = Json::parse(text);
    json.erase("manifest_checksum");
    const std::vector<Json> values = {nullptr,
                                      -1,
                                      0,
                                      1,
                                      7,
                                      std::int64_t{1} << 40,
                                      1.5,
                                      true,
                                      "",
                                      "12",
                                      "0xffff",
                                      "zzzzzzzzzzzzzzzz",
                                      Json::array(),
                                      Json::object(),
                                      std::numeric_limits<std::uint64_t>::max(),
                                      std::numeric_limits<std::int64_t>::min()};
    for (int k = 0; k < 3 && !bytes.empty(); ++k) {
        auto at = json.begin();
        std::advance(at, static_cast<std::ptrdiff_t>(bytes.below(json.size())));
        const auto key = at.key();
        if (bytes.below(4) == 0) {
            json.erase(key);
        } else {
            json[key] = values[bytes.below(values.size())];
        }
    }
    json["manifest_checksum"] = hex_digits(checksum(format_summary(json)));
    return format_summary(json);
}

/// Blind changes: a position, and what is there instead.
std::string spoiled(std::string text, ByteSource& bytes) {
    for (int k = 0; k < 4 && !bytes.empty() && !text.empty(); ++k) {
        const auto at = (bytes.next() * 256U + bytes.next()) % text.size();
        switch (bytes.below(4)) {
        case 0:
            text.resize(at);
            break;
        case 1:
            text.insert(at, std::string(bytes.below(200), static_cast<char>(bytes.next())));
            break;
        default:
            text[at] = static_cast<char>(text[at] ^ static_cast<char>(1U << bytes.below(8)));
        }
    }
    return text;
}

bool are_numbers(std::initializer_list<double> values) {
    return std::all_of(values.begin(), values.end(), [](double a) { return std::isfinite(a); });
}

void require(bool holds, const char* what) {
    if (!holds) {
        broken("what is taken from a file is sound", what);
    }
}

// The rules said once more, in other words than io/row_rules.cpp.

template <class Row>
void check_grain(const Row& g, GlobalId id) {
    require(g.id == id, "ids 0 … n-1, once each");
    require(are_numbers({g.x[0], g.x[1], g.v[0], g.v[1], g.rotation[0], g.mass}), "numbers");
    require(g.mass > 0 && g.radius > 0.4199 && g.radius < 0.5701 && g.material >= 0 && g.material < 2, "ranges");
}

void check_contacts(const std::vector<ContactRow<2>>& contacts, GlobalId n) {
    std::set<std::pair<GlobalId, GlobalId>> pairs;
    for (const auto& c : contacts) {
        require(c.lo >= 0 && c.lo < n && c.hi > c.lo && (c.hi < n || (c.hi >= wall_key && c.hi < wall_key + n_faces)),
                "partners");
        require(pairs.empty() || *pairs.rbegin() < std::pair(c.lo, c.hi), "order");
        require(are_numbers({c.r_n, c.r_t[0]}), "impulses");
        pairs.emplace(c.lo, c.hi);
    }
}

void check_sample(const StoredSample<2>& sample) {
    const auto n = static_cast<GlobalId>(sample.grains.size());
    require(sample.n_grains == n && sample.n_contacts == static_cast<std::int64_t>(sample.contacts.size()), "counts");
    for (GlobalId i = 0; i < n; ++i) {
        const auto& g = sample.grains[static_cast<std::size_t>(i)];
        check_grain(g, i);
        require(are_numbers({g.spin[0]}), "spin");
    }
    check_contacts(sample.contacts, n);
}

void check_checkpoint(const Checkpoint<2>& checkpoint) {
    const auto& snapshot = checkpoint.snapshot;
    const auto n = static_cast<GlobalId>(snapshot.grains.size());
    for (GlobalId i = 0; i < n; ++i) {
        const auto& g = snapshot.grains[static_cast<std::size_t>(i)];
        check_grain(g, i);
        require(are_numbers({g.x_ref[0], g.x_ref[1], g.s[0], g.margin}), "numbers of the last rebuild");
    }
    check_contacts(snapshot.impulses, n);
    const auto scene = parse_scene(checkpoint.scene, "stored");
    require(snapshot.walls.size() == scene.walls.size(), "walls of the scene");
    require(snapshot.clock.stage >= 0 && snapshot.clock.stage < static_cast<std::int64_t>(scene.stages.size()),
            "stage");
    require(snapshot.clock.steps >= 0 && are_numbers({snapshot.clock.impulse_h}), "clock");
    require(checkpoint.course.is_object(), "course");
}

void check_reason(const std::string& reason, const std::string& written) {
    if (const auto fault = fuzz::fault_of_text(reason, written); !fault.empty()) {
        broken("a reason is said in words; this " + fault, reason);
    }
}

} // namespace

int LLVMFuzzerInitialize(int* argc, char*** argv) {
    ::setenv("OMPI_MCA_opal_signal", "", 1); // signals are libFuzzer's, which keeps the input that caused one
    world = std::make_unique<World>(*argc, *argv);
    std::atexit([] { world.reset(); });
    return 0;
}

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    ByteSource bytes({data, size});
    const auto first = bytes.next();
    const auto way = first % 4;
    const bool checkpoint = first / 4 % 2 == 1;
    const auto& sound = sound_file(checkpoint, static_cast<GlobalId>(bytes.below(9)));
    const auto& path = sound.path;
    std::string file = sound.file;
    std::string manifest = sound.manifest;
    if (way == 1) {
        file = spoiled(file, bytes);
    } else if (way == 2) {
        manifest = spoiled(manifest, bytes);
    } else if (way == 3) {
        manifest = forged_manifest(manifest, bytes);
    }
    const bool edited = way == 0 && !bytes.empty();
    std::filesystem::remove(path);
    write(path, file);
    if (edited) {
        fuzz::edit_stored(path, bytes);
        manifest = format_manifest(manifest_of(path, manifest));
    }
    write(manifest_path(path), manifest);

    bool taken = false;
    std::string reason;
    if (checkpoint) {
        const auto found = load_newest_checkpoint<2>(world->comm, world->folder);
        taken = found.checkpoint.has_value();
        reason = taken ? "" : found.blocked.empty() ? found.reasons.at(0) : found.blocked;
        if (taken) {
            check_checkpoint(*found.checkpoint);
        }
    } else {
        const auto found = load_sample<2>(world->comm, world->folder, origin, row_limits(world->scene));
        taken = found.sample.has_value();
        reason = found.reason;
        if (taken) {
            check_sample(*found.sample);
        }
    }
    if (!taken) {
        check_reason(reason, manifest);
    }
    const bool said =
        reason.find(" is damaged") != std::string::npos || reason.find(" bytes instead of ") != std::string::npos;
    if (way == 1 && file != sound.file && !said) {
        broken("a damaged file is refused before HDF5 opens it", reason);
    }
    if (!edited && file == sound.file && manifest == sound.manifest && !taken) {
        broken("a sound file is taken", reason);
    }
    return 0;
}

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned) {
    return LLVMFuzzerMutate(data, size, max_size);
}
