// What stands between a stored file and a computation: load_sample either returns a sample that a computation may start
// from, or says why not. A file that is not what its manifest says is refused before HDF5 opens it.
//
// An input: how to spoil a sound sample (first byte modulo 4), its number of grains, and where to spoil it.
// Faults inside HDF5 behind a valid checksum are out of scope: HDF5 1.10.8 has them.
#include "fuzz/fuzz_target.hpp"
#include "fuzz/message_rules.hpp"
#include "fuzz/stored_edits.hpp"

#include "io/checksum.hpp"
#include "io/sample_store.hpp"
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
const RowLimits limits{2, 0.42, 0.57, 40};

/// A sound sample as it lies on disk.
struct Stored {
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
    std::map<GlobalId, Stored> sound; ///< by number of grains
};
std::unique_ptr<World> world;

void write(const std::filesystem::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

std::string read(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

const Stored& sound_sample(GlobalId n) {
    auto& stored = world->sound[n];
    if (stored.file.empty()) {
        std::vector<GrainRow<2>> grains;
        std::vector<ContactRow<2>> contacts;
        for (GlobalId id = 0; id < n; ++id) {
            grains.push_back(test::made_up_grain(id));
            const auto rows = test::made_up_contacts(id, n);
            contacts.insert(contacts.end(), rows.begin(), rows.end());
        }
        store_sample<2>(world->comm, world->folder, origin, grains, contacts, {{"settle_steps", 12}});
        const auto path = sample_path(world->folder, origin);
        stored = {read(path), read(manifest_path(path))};
    }
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

/// Said once more, and in other words than io/row_rules.cpp.
void check_sample(const StoredSample<2>& sample) {
    const auto require = [](bool holds, const char* what) {
        if (!holds) {
            broken("a sample is sound", what);
        }
    };
    const auto n = static_cast<GlobalId>(sample.grains.size());
    require(sample.n_grains == n && sample.n_contacts == static_cast<std::int64_t>(sample.contacts.size()), "counts");
    for (GlobalId i = 0; i < n; ++i) {
        const auto& g = sample.grains[static_cast<std::size_t>(i)];
        require(g.id == i, "ids 0 … n-1, once each");
        require(are_numbers({g.x[0], g.x[1], g.v[0], g.v[1], g.spin[0], g.rotation[0], g.mass}), "numbers");
        require(g.mass > 0 && g.radius >= 0.42 && g.radius <= 0.57 && g.material >= 0 && g.material < 2, "ranges");
    }
    std::set<std::pair<GlobalId, GlobalId>> pairs;
    for (const auto& c : sample.contacts) {
        require(c.lo >= 0 && c.lo < n && c.hi > c.lo && (c.hi < n || (c.hi >= wall_key && c.hi < wall_key + 40)),
                "partners");
        require(pairs.empty() || *pairs.rbegin() < std::pair(c.lo, c.hi), "order");
        require(are_numbers({c.r_n, c.r_t[0]}), "impulses");
        pairs.emplace(c.lo, c.hi);
    }
}

void check_reason(const std::string& reason, const std::string& written) {
    if (const auto fault = fuzz::fault_of_text(reason, written); !fault.empty()) {
        broken("a reason is said in words; this " + fault, reason);
    }
}

} // namespace

int LLVMFuzzerInitialize(int* argc, char*** argv) {
    world = std::make_unique<World>(*argc, *argv);
    std::atexit([] { world.reset(); });
    return 0;
}

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    ByteSource bytes({data, size});
    const auto way = bytes.below(4);
    const auto& sound = sound_sample(static_cast<GlobalId>(bytes.below(9)));
    const auto path = sample_path(world->folder, origin);
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

    const auto found = load_sample<2>(world->comm, world->folder, origin, limits);
    if (!found.sample) {
        check_reason(found.reason, manifest);
    } else {
        check_sample(*found.sample);
    }
    if (way == 1 && file != sound.file &&
        (found.sample || (found.reason.find(" is damaged") == std::string::npos &&
                          found.reason.find(" bytes instead of ") == std::string::npos))) {
        broken("a damaged file is refused before HDF5 opens it", found.reason);
    }
    if (!edited && file == sound.file && manifest == sound.manifest && !found.sample) {
        broken("a sound sample is taken", found.reason);
    }
    return 0;
}

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned) {
    return LLVMFuzzerMutate(data, size, max_size);
}
