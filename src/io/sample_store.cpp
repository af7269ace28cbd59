#include "io/sample_store.hpp"

#include "core/error.hpp"
#include "io/atomic_file.hpp"
#include "io/checksum.hpp"
#include "io/hdf5_reader.hpp"
#include "io/hdf5_writer.hpp"
#include "io/sample_manifest.hpp"
#include "io/summary.hpp"

#include <algorithm>
#include <type_traits>

namespace nappe {

namespace {

/// Every field of a grain, for storing and for loading: visit(path, columns, pointer to the field's first element).
template <int D, class Visit>
void visit_grain_fields(Visit visit) {
    visit("/grains/id", 1, [](auto& g) { return &g.id; });
    visit("/grains/position", D, [](auto& g) { return g.x.data(); });
    visit("/grains/velocity", D, [](auto& g) { return g.v.data(); });
    visit("/grains/spin", n_spin<D>, [](auto& g) { return g.spin.data(); });
    visit("/grains/rotation", n_spin<D>, [](auto& g) { return g.rotation.data(); });
    visit("/grains/radius", 1, [](auto& g) { return &g.radius; });
    visit("/grains/mass", 1, [](auto& g) { return &g.mass; });
    visit("/grains/cells", 1, [](auto& g) { return &g.cells; });
    visit("/grains/material", 1, [](auto& g) { return &g.material; });
    visit("/grains/layer", 1, [](auto& g) { return &g.layer; });
}

template <int D, class Visit>
void visit_contact_fields(Visit visit) {
    visit("/contacts/lo", 1, [](auto& c) { return &c.lo; });
    visit("/contacts/hi", 1, [](auto& c) { return &c.hi; });
    visit("/contacts/r_n", 1, [](auto& c) { return &c.r_n; });
    visit("/contacts/r_t", D - 1, [](auto& c) { return c.r_t.data(); });
}

template <class Row, class Field>
using FieldType = std::remove_cvref_t<decltype(*std::declval<Field>()(std::declval<Row&>()))>;

/// A visitor that adds each field of the rows to a file's content.
template <class Row>
auto adding_to(Hdf5Content& content, const RowRange& range, const std::vector<Row>& rows) {
    return [&content, range, &rows](const char* path, int columns, auto field) {
        using T = FieldType<const Row, decltype(field)>;
        content.add<T>(path, columns, range, rows,
                       [&](const Row& row, T* out) { std::copy_n(field(row), columns, out); });
    };
}

constexpr const char* offsets_path = "/grains/first_contact";
constexpr const char* origin_path = "/made_from";

/// Where each grain's contacts begin in the whole list, and its length at the end: lets any rank count find the
/// contacts of its block.
template <int D>
void add_offsets(const Communicator& comm, const RowRange& grain_range, const RowRange& contact_range,
                 const std::vector<ContactRow<D>>& contacts, Hdf5Content& content) {
    std::vector<std::int64_t> offsets;
    auto next = contacts.begin();
    for (GlobalId id = grain_range.first; id < grain_range.first + grain_range.rows; ++id) {
        next = std::find_if(next, contacts.end(), [&](const auto& c) { return c.lo >= id; });
        offsets.push_back(contact_range.first + (next - contacts.begin()));
    }
    if (comm.rank() == comm.size() - 1) {
        offsets.push_back(contact_range.total);
    }
    const RowRange range{grain_range.first, static_cast<std::int64_t>(offsets.size()), grain_range.total + 1};
    content.add<std::int64_t>(offsets_path, range, offsets, [](std::int64_t offset) { return offset; });
}

void add_origin(const Communicator& comm, const SampleOrigin& origin, Hdf5Content& content) {
    // A dataset, since attributes end at 64 kB.
    const std::string mine = comm.is_root() ? origin.made_from : std::string();
    const auto total = static_cast<std::int64_t>(origin.made_from.size());
    const RowRange range{comm.is_root() ? 0 : total, comm.is_root() ? total : 0, total};
    content.add<std::uint8_t>(origin_path, range, mine, [](char c) { return static_cast<std::uint8_t>(c); });
    content.attributes.push_back({"/", "key", origin.key()});
    content.attributes.push_back({"/", "physics_revision", origin.physics_revision});
    content.attributes.push_back({"/", "version", std::string(program_version())});
}

/// The checksum of every whole dataset, as an attribute of it. Collective.
void add_checksums(const Communicator& comm, Hdf5Content& content) {
    for (const auto& dataset : content.datasets) {
        const auto mine = row_checksum(dataset.bytes, dataset.row_bytes(), dataset.range.first);
        content.attributes.push_back({dataset.path, "checksum", comm.sum_wrapping(mine)});
    }
}

std::filesystem::path manifest_path(std::filesystem::path path) {
    return path.replace_extension(".json");
}

/// What rank 0 does alone at an end of the protocol; its failure is everyone's. Collective.
template <class Action>
void on_root(const Communicator& comm, Action action) {
    std::string error;
    if (comm.is_root()) {
        try {
            action();
        } catch (const std::exception& failure) {
            error = failure.what();
        }
    }
    comm.throw_together<SystemError>(error);
}

/// Reads this rank's slabs, and remembers what must be checked with the other ranks. Local.
class SlabReader {
public:
    explicit SlabReader(const std::filesystem::path& path) : file_(path) {}

    /// Rows [first, first + rows) that count as this rank's in the checksum of the dataset.
    template <class T>
    std::vector<T> read(const std::string& path, int columns, std::int64_t first, std::int64_t rows) {
        auto values = file_.read<T>(path, first, rows, columns);
        const auto row_bytes = sizeof(T) * static_cast<std::size_t>(columns);
        checks_.push_back(
            {path, file_.bits(path, "checksum"), row_checksum(std::as_bytes(std::span(values)), row_bytes, first)});
        return values;
    }

    const Hdf5Reader& file() const { return file_; }

    struct Check {
        std::string path;
        std::uint64_t expected;
        std::uint64_t mine;
    };
    const std::vector<Check>& checks() const { return checks_; }

private:
    Hdf5Reader file_;
    std::vector<Check> checks_;
};

/// A visitor that fills each field of the rows from the file.
template <class Row>
auto filling(SlabReader& reader, std::int64_t first, std::vector<Row>& rows) {
    return [&reader, first, &rows](const char* path, int columns, auto field) {
        using T = FieldType<Row, decltype(field)>;
        const auto values = reader.read<T>(path, columns, first, static_cast<std::int64_t>(rows.size()));
        const T* from = values.data();
        for (Row& row : rows) {
            std::copy_n(from, columns, field(row));
            from += columns;
        }
    };
}

/// This rank's part. Local; throws if the file is not what it should be.
template <int D>
StoredSample<D> read_sample(const Communicator& comm, SlabReader& reader, const SampleOrigin& origin,
                            const SampleManifest& manifest) {
    const auto& file = reader.file();
    const auto made_from = file.read<std::uint8_t>(origin_path);
    if (file.bits("/", "key") != origin.key() || file.integer("/", "physics_revision") != origin.physics_revision ||
        std::string(made_from.begin(), made_from.end()) != origin.made_from) {
        throw std::runtime_error("the file is of another sample");
    }
    const IdBlocks blocks{manifest.n_grains, comm.size()};
    const auto first = blocks.first(comm.rank());
    const auto count = blocks.count(comm.rank());
    const bool last_rank = comm.rank() == comm.size() - 1;

    StoredSample<D> sample;
    sample.n_grains = manifest.n_grains;
    sample.n_contacts = manifest.n_contacts;
    sample.notes = manifest.notes;
    sample.grains.resize(static_cast<std::size_t>(count));
    visit_grain_fields<D>(filling(reader, first, sample.grains));

    auto offsets = reader.read<std::int64_t>(offsets_path, 1, first, count + (last_rank ? 1 : 0));
    if (!last_rank) {
        offsets.push_back(file.read<std::int64_t>(offsets_path, first + count, 1).front());
    }
    sample.contacts.resize(static_cast<std::size_t>(offsets.back() - offsets.front()));
    visit_contact_fields<D>(filling(reader, offsets.front(), sample.contacts));
    return sample;
}

/// Length and checksum of the file against the manifest; the reason not to use it, or nothing. Collective.
std::string damage(const Communicator& comm, const std::filesystem::path& path, const SampleManifest& manifest) {
    std::error_code missing;
    const auto bytes = std::filesystem::file_size(path, missing);
    std::string reason;
    if (missing) {
        reason = path.string() + " is not there";
    } else if (bytes != manifest.file_bytes) {
        reason = fmt::format("{} has {} bytes instead of {}", path.string(), bytes, manifest.file_bytes);
    }
    reason = comm.first_error(reason);
    if (!reason.empty()) {
        return reason;
    }
    try {
        return file_checksum(comm, path) == manifest.file_checksum ? std::string() : path.string() + " is damaged";
    } catch (const SystemError& failure) { // thrown on all ranks alike
        return failure.what();
    }
}

} // namespace

std::uint64_t SampleOrigin::key() const {
    return checksum(fmt::format("{}\n{}", physics_revision, made_from));
}

std::filesystem::path sample_path(const std::filesystem::path& folder, const SampleOrigin& origin) {
    return folder / (hex_digits(origin.key()) + ".hdf");
}

template <int D>
void store_sample(const Communicator& comm, const std::filesystem::path& folder, const SampleOrigin& origin,
                  std::vector<GrainRow<D>> grains, std::vector<ContactRow<D>> contacts,
                  const nlohmann::ordered_json& notes) {
    const auto path = sample_path(folder, origin);
    const IdBlocks blocks{comm.sum(static_cast<std::int64_t>(grains.size())), comm.size()};
    grains = grains_in_blocks(comm, blocks, std::move(grains), [](const GrainRow<D>& g) { return g.id; });
    contacts = contacts_in_blocks(comm, blocks, std::move(contacts));
    const RowRange grain_range{blocks.first(comm.rank()), blocks.count(comm.rank()), blocks.n};
    const RowRange contact_range = row_range(comm, contacts.size());

    Hdf5Content content;
    visit_grain_fields<D>(adding_to(content, grain_range, grains));
    visit_contact_fields<D>(adding_to(content, contact_range, contacts));
    add_offsets(comm, grain_range, contact_range, contacts, content);
    add_origin(comm, origin, content);
    add_checksums(comm, content);
    on_root(comm, [&] { std::filesystem::create_directories(folder); });
    write_hdf5(comm, path, content);

    SampleManifest manifest{origin.key(), origin.physics_revision, blocks.n, contact_range.total, 0, 0, notes};
    manifest.file_checksum = file_checksum(comm, path);
    on_root(comm, [&] {
        manifest.file_bytes = std::filesystem::file_size(path);
        write_file_atomically(manifest_path(path), format_manifest(manifest));
    });
}

template <int D>
SampleLookup<D> load_sample(const Communicator& comm, const std::filesystem::path& folder, const SampleOrigin& origin) {
    const auto path = sample_path(folder, origin);
    std::string text;
    SampleManifest manifest;
    std::string reason;
    if (comm.is_root()) {
        try {
            text = read_text(manifest_path(path));
            manifest = parse_manifest(text, origin.key());
        } catch (const std::exception& failure) {
            reason = failure.what();
        }
    }
    reason = comm.first_error(reason);
    if (!reason.empty()) {
        return {std::nullopt, reason};
    }
    comm.broadcast(text);
    manifest = parse_manifest(text, origin.key());
    reason = damage(comm, path, manifest);
    if (!reason.empty()) {
        return {std::nullopt, reason};
    }

    StoredSample<D> sample;
    std::vector<SlabReader::Check> checks;
    try {
        SlabReader reader(path);
        sample = read_sample<D>(comm, reader, origin, manifest);
        checks = reader.checks();
    } catch (const std::exception& failure) {
        reason = path.string() + ": " + failure.what();
    }
    reason = comm.first_error(reason);
    if (!reason.empty()) {
        return {std::nullopt, reason};
    }
    for (const auto& check : checks) {
        if (comm.sum_wrapping(check.mine) != check.expected) {
            return {std::nullopt, fmt::format("{}: dataset {} is damaged", path.string(), check.path)};
        }
    }
    return {std::move(sample), {}};
}

template void store_sample<2>(const Communicator&, const std::filesystem::path&, const SampleOrigin&,
                              std::vector<GrainRow<2>>, std::vector<ContactRow<2>>, const nlohmann::ordered_json&);
template SampleLookup<2> load_sample<2>(const Communicator&, const std::filesystem::path&, const SampleOrigin&);

} // namespace nappe
