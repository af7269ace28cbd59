#include "io/checkpoint_store.hpp"
#include "io/atomic_file.hpp"

#include "core/error.hpp"
#include "io/id_blocks.hpp"
#include "io/row_rules.hpp"
#include "io/scene_reader.hpp"
#include "io/stored_rows.hpp"
#include "io/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fcntl.h>
#include <stdexcept>

namespace nappe {

namespace {

template <int D, class Visit>
void visit_kept_fields(Visit visit) {
    visit("/grains/id", 1, [](auto& g) { return &g.id; });
    visit("/grains/position", D, [](auto& g) { return g.x.data(); });
    visit("/grains/reference", D, [](auto& g) { return g.x_ref.data(); });
    visit("/grains/velocity", D, [](auto& g) { return g.v.data(); });
    visit("/grains/rim_speed", n_spin<D>, [](auto& g) { return g.s.data(); });
    visit("/grains/rotation", n_spin<D>, [](auto& g) { return g.rotation.data(); });
    visit("/grains/radius", 1, [](auto& g) { return &g.radius; });
    visit("/grains/mass", 1, [](auto& g) { return &g.mass; });
    visit("/grains/margin", 1, [](auto& g) { return &g.margin; });
    visit("/grains/cells", 1, [](auto& g) { return &g.cells; });
    visit("/grains/material", 1, [](auto& g) { return &g.material; });
    visit("/grains/layer", 1, [](auto& g) { return &g.layer; });
}

template <int D, class Visit>
void visit_wall_fields(Visit visit) {
    visit("/walls/offset", D, [](auto& w) { return w.offset.data(); });
    visit("/walls/offset_ref", D, [](auto& w) { return w.offset_ref.data(); });
    visit("/walls/v", D, [](auto& w) { return w.v.data(); });
    visit("/walls/v_old", D, [](auto& w) { return w.v_old.data(); });
    visit("/walls/margin", 1, [](auto& w) { return &w.margin; });
}

template <class Visit>
void visit_owner_fields(Visit visit) {
    visit("/tiles/key", 1, [](auto& o) { return &o.key; });
    visit("/tiles/rank", 1, [](auto& o) { return &o.rank; });
}

constexpr const char* sums_path = "/sums";
constexpr const char* scene_path = "/scene";
constexpr const char* course_path = "/course";
constexpr const char* clock_path = "/clock";

/// Rows that all ranks have alike are the root's to write.
template <class Row>
std::vector<Row> on_root_only(const Communicator& comm, const std::vector<Row>& rows) {
    return comm.is_root() ? rows : std::vector<Row>();
}

std::string version_of(const nlohmann::ordered_json& notes) {
    const auto at = notes.find("version");
    return at != notes.end() && at->is_string() ? at->get<std::string>() : "?";
}

std::string text_of(SnapshotClock clock) {
    nlohmann::ordered_json json;
    clock.for_each([&](const char* name, auto& value) { json[name] = value; });
    return format_summary(json);
}

SnapshotClock clock_of(const std::string& text) {
    const auto json = parse_shallow(text);
    SnapshotClock clock;
    clock.for_each([&](const char* name, auto& value) {
        const auto at = json.is_object() ? json.find(name) : json.end();
        using T = std::remove_cvref_t<decltype(value)>;
        if (at == json.end() || !(std::is_integral_v<T> ? at->is_number_integer() : at->is_number())) {
            throw std::runtime_error(fmt::format("{}: must give {} as a number", clock_path, name));
        }
        at->get_to(value);
    });
    return clock;
}

/// A small table that every rank reads whole, and that the root checks; empty if its group is not there.
template <class Row, class VisitFields>
std::vector<Row> read_whole(const Communicator& comm, SlabReader& reader, const char* group, const char* counted,
                            VisitFields visit) {
    if (!reader.file().has(group)) {
        return {};
    }
    const auto n = reader.file().stored_rows(counted);
    std::vector<Row> rows(static_cast<std::size_t>(n));
    visit([&](const char* path, int columns, auto field) {
        using T = FieldType<Row, decltype(field)>;
        const auto values = reader.read_shared<T>(comm, path, columns, n);
        const T* from = values.data();
        for (Row& row : rows) {
            std::copy_n(from, columns, field(row));
            from += columns;
        }
    });
    return rows;
}

/// This rank's part. Throws if the file is not what it should be.
template <int D>
Checkpoint<D> read_checkpoint(const Communicator& comm, SlabReader& reader, const StoredManifest& manifest) {
    Checkpoint<D> checkpoint;
    checkpoint.key = manifest.key;
    checkpoint.notes = manifest.notes;
    const auto ranks = manifest.notes.find("ranks");
    if (ranks == manifest.notes.end() || !ranks->is_number_integer()) {
        throw std::runtime_error("the manifest's notes must give the number of ranks");
    }
    ranks->get_to(checkpoint.ranks);
    checkpoint.scene = reader.read_text(comm, scene_path);
    checkpoint.course = parse_shallow(reader.read_text(comm, course_path));
    if (!checkpoint.course.is_object()) {
        throw std::runtime_error(fmt::format("{}: must be a table, found none", course_path));
    }
    auto& snapshot = checkpoint.snapshot;
    snapshot.clock = clock_of(reader.read_text(comm, clock_path));

    const IdBlocks blocks{manifest.n_grains, comm.size()};
    const auto first = blocks.first(comm.rank());
    const auto count = blocks.count(comm.rank());
    reader.expect_rows(manifest);
    snapshot.grains.resize(static_cast<std::size_t>(count));
    visit_kept_fields<D>(filling(reader, first, snapshot.grains));
    snapshot.impulses = reader.read_contacts<D>(first, count, comm.rank() == comm.size() - 1);
    snapshot.walls = read_whole<SnapshotWall<D>>(comm, reader, "/walls", "/walls/margin",
                                                 [](auto visit) { visit_wall_fields<D>(visit); });
    snapshot.owners =
        read_whole<TileOwner>(comm, reader, "/tiles", "/tiles/key", [](auto visit) { visit_owner_fields(visit); });
    snapshot.sums = reader.read_shared<std::int64_t>(comm, sums_path, 1, reader.file().rows(sums_path));
    const auto scene = parse_scene(checkpoint.scene, "its scene");
    if (const auto broken = broken_rule<D>(snapshot, scene, first, manifest.n_grains); !broken.empty()) {
        throw std::runtime_error(broken);
    }
    return checkpoint;
}

/// N of the files checkpoint-N with this ending, ascending.
std::vector<std::int64_t> serials_of(const std::filesystem::path& folder, std::string_view after) {
    std::vector<std::int64_t> serials;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
        const auto name = entry.path().filename().string();
        constexpr std::string_view before = "checkpoint-";
        if (!name.starts_with(before) || !name.ends_with(after)) {
            continue;
        }
        std::int64_t serial = 0;
        const char* const end = name.data() + name.size() - after.size();
        const auto read = std::from_chars(name.data() + before.size(), end, serial);
        if (read.ec == std::errc() && read.ptr == end) {
            serials.push_back(serial);
        }
    }
    std::sort(serials.begin(), serials.end());
    return serials;
}

} // namespace

std::filesystem::path checkpoint_path(const std::filesystem::path& folder, std::int64_t serial) {
    return folder / fmt::format("checkpoint-{:06}.hdf", serial);
}

std::vector<std::int64_t> checkpoint_serials(const std::filesystem::path& folder) {
    return serials_of(folder, ".json");
}

void remove_checkpoint(const std::filesystem::path& folder, std::int64_t serial) {
    const auto path = checkpoint_path(folder, serial);
    std::error_code ignored;
    std::filesystem::remove(manifest_path(path), ignored);
    std::filesystem::remove(path, ignored);
}

void remove_orphans(const std::filesystem::path& folder) {
    for (const auto serial : serials_of(folder, ".hdf")) {
        std::error_code ignored;
        if (!std::filesystem::exists(manifest_path(checkpoint_path(folder, serial)), ignored)) {
            remove_checkpoint(folder, serial);
        }
    }
}

template <int D>
void store_checkpoint(const Communicator& comm, const std::filesystem::path& folder, Checkpoint<D> checkpoint) {
    auto& snapshot = checkpoint.snapshot;
    const IdBlocks blocks{comm.sum(static_cast<std::int64_t>(snapshot.grains.size())), comm.size()};
    const auto grains =
        grains_in_blocks(comm, blocks, std::move(snapshot.grains), [](const SnapshotGrain<D>& g) { return g.id; });
    const auto contacts = contacts_in_blocks(comm, blocks, std::move(snapshot.impulses));
    const RowRange grain_range{blocks.first(comm.rank()), blocks.count(comm.rank()), blocks.n};
    const RowRange contact_range = row_range(comm, contacts.size());

    Hdf5Content content;
    visit_kept_fields<D>(adding_to(content, grain_range, grains));
    visit_contact_fields<D>(adding_to(content, contact_range, contacts));
    add_offsets(comm, grain_range, contact_range, contacts, content);
    const auto walls = on_root_only(comm, snapshot.walls);
    const auto owners = on_root_only(comm, snapshot.owners);
    if (!snapshot.walls.empty()) {
        visit_wall_fields<D>(adding_to(content, by_root(comm, snapshot.walls.size()), walls));
    }
    if (!snapshot.owners.empty()) {
        visit_owner_fields(adding_to(content, by_root(comm, snapshot.owners.size()), owners));
    }
    content.add<std::int64_t>(sums_path, by_root(comm, snapshot.sums.size()), on_root_only(comm, snapshot.sums),
                              [](std::int64_t limb) { return limb; });
    std::string course = format_summary(checkpoint.course); // in which seconds are each rank's own
    comm.broadcast(course);
    add_text(comm, scene_path, checkpoint.scene, content);
    add_text(comm, course_path, course, content);
    add_text(comm, clock_path, text_of(snapshot.clock), content);
    add_checksums(comm, content);

    nlohmann::ordered_json notes{
        {"kind", "checkpoint"}, {"version", program_version()}, {"ranks", comm.size()}, {"serial", checkpoint.serial}};
    notes.update(checkpoint.notes);
    write_stored(comm, checkpoint_path(folder, checkpoint.serial), content,
                 {checkpoint.key, physics_revision, blocks.n, contact_range.total, 0, 0, notes});
}

namespace {

/// On the root. Why a checkpoint that is there can not be read by this process: rights, a disk that fails, too many open files.
std::string unreadable(const std::filesystem::path& path) {
    for (const auto& part : {manifest_path(path), path}) {
        std::error_code none;
        if (std::filesystem::exists(std::filesystem::symlink_status(part, none))) {
            try {
                const FileDescriptor file(part, O_RDONLY);
            } catch (const SystemError& e) {
                return fmt::format(
                    "{}; make it readable, or take this checkpoint out of the folder to go on from the one "
                    "before",
                    e.what());
            }
        }
    }
    return {};
}

} // namespace

template <int D>
CheckpointLookup<D> load_newest_checkpoint(const Communicator& comm, const std::filesystem::path& folder) {
    CheckpointLookup<D> found;
    // Together: a folder may look different from two nodes for a while.
    auto serials = comm.all_gather(comm.is_root() ? checkpoint_serials(folder) : std::vector<std::int64_t>());
    for (auto serial = serials.rbegin(); serial != serials.rend(); ++serial) {
        const auto path = checkpoint_path(folder, *serial);
        found.blocked = comm.first_error(comm.is_root() ? unreadable(path) : std::string());
        if (!found.blocked.empty()) {
            return found;
        }
        const auto file = examine_stored(comm, path);
        std::string reason = file.reason;
        if (reason.empty() && file.manifest.physics_revision != physics_revision) {
            found.blocked =
                fmt::format("{}: is of nappe {}, physics {}, found by nappe {}, physics {}: it would go on to other "
                            "results; go on with the program that wrote it",
                            path.string(), version_of(file.manifest.notes), file.manifest.physics_revision,
                            program_version(), physics_revision);
            return found;
        }
        if (reason.empty()) {
            Checkpoint<D> checkpoint;
            reason = read_stored(
                comm, path, [&](SlabReader& reader) { checkpoint = read_checkpoint<D>(comm, reader, file.manifest); });
            if (reason.empty()) {
                checkpoint.serial = *serial;
                found.checkpoint = std::move(checkpoint);
                return found;
            }
        }
        found.reasons.push_back(reason);
    }
    return found;
}

template void store_checkpoint<2>(const Communicator&, const std::filesystem::path&, Checkpoint<2>);
template CheckpointLookup<2> load_newest_checkpoint<2>(const Communicator&, const std::filesystem::path&);

} // namespace nappe
