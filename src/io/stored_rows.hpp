#pragma once
// What samples and checkpoints share: tables of rows in an HDF5 file with a checksum for each, sorted by GlobalId so that
// any number of ranks can read what any other wrote, and a manifest that is written last.

#include "core/rows.hpp"
#include "io/hdf5_content.hpp"
#include "io/hdf5_reader.hpp"
#include "io/stored_manifest.hpp"
#include "parallel/communicator.hpp"

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace nappe {

/// The impulses of contacts, for storing and for loading: visit(path, columns, pointer to the field's first element).
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

/// A text, the same on all ranks, as a dataset: attributes end at 64 kB. An empty one has no dataset.
void add_text(const Communicator& comm, const char* path, const std::string& text, Hdf5Content& content);

/// Where each grain's contacts begin in the whole list, and its length at the end: lets any rank count find the contacts
/// of its block of ids.
template <int D>
void add_offsets(const Communicator& comm, const RowRange& grain_range, const RowRange& contact_range,
                 const std::vector<ContactRow<D>>& contacts, Hdf5Content& content);

/// **Collective.** The checksum of every whole dataset, as an attribute of it. To be called last.
void add_checksums(const Communicator& comm, Hdf5Content& content);

/// **Collective.** What is written under `path` is complete and verified, then the manifest beside it is written, with
/// length and checksum filled in. Throws SystemError on all ranks; files of these names that were there are then still
/// whole, or not used.
void write_stored(const Communicator& comm, const std::filesystem::path& path, const Hdf5Content& content,
                  StoredManifest manifest);

/// What is known of a stored file before HDF5 opens it.
struct StoredFile {
    StoredManifest manifest;
    std::string
        reason; ///< why it is not to be used: no file, no manifest, damage. Same on all ranks; empty: it is sound
};

/// **Collective.** Reads the manifest and checks length and checksum of the file. Does not throw for what is on disk.
StoredFile examine_stored(const Communicator& comm, const std::filesystem::path& path);

/// Reads this rank's slabs, and remembers what must be checked with the other ranks. Local.
class SlabReader {
public:
    explicit SlabReader(const std::filesystem::path& path) : file_(path) {}

    /// Rows [first, first + rows) that count as this rank's in the checksum of the dataset. Throws Hdf5Failure.
    template <class T>
    std::vector<T> read(const std::string& path, int columns, std::int64_t first, std::int64_t rows) {
        auto values = file_.read<T>(path, first, rows, columns);
        remember(path, std::as_bytes(std::span(values)), sizeof(T) * static_cast<std::size_t>(columns), first);
        return values;
    }

    /// Rows [0, rows), all of them on every rank, checked by the root.
    template <class T>
    std::vector<T> read_shared(const Communicator& comm, const std::string& path, int columns, std::int64_t rows) {
        auto values = file_.read<T>(path, 0, rows, columns);
        remember(path, comm.is_root() ? std::as_bytes(std::span(values)) : std::span<const std::byte>(),
                 sizeof(T) * static_cast<std::size_t>(columns), 0);
        return values;
    }

    /// A text of `add_text`: all of it on every rank, checked by the root.
    std::string read_text(const Communicator& comm, const char* path);

    /// Throws Hdf5Failure unless there are as many grains and contacts as the manifest says: before room is made for them.
    void expect_rows(const StoredManifest& manifest) const;

    /// The contacts of the grains [first, first + count), by the table of `add_offsets`.
    template <int D>
    std::vector<ContactRow<D>> read_contacts(std::int64_t first, std::int64_t count, bool last_rank);

    const Hdf5Reader& file() const { return file_; }

    struct Check {
        std::string path;
        std::uint64_t expected;
        std::uint64_t mine;
    };
    const std::vector<Check>& checks() const { return checks_; }

private:
    void remember(const std::string& path, std::span<const std::byte> bytes, std::size_t row_bytes, std::int64_t first);

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

/// **Collective.** read(reader) on every rank, then the checksums of all that it read; what went wrong on any, the same
/// on all ranks, or nothing.
template <class Read>
std::string read_stored(const Communicator& comm, const std::filesystem::path& path, Read read);

/// **Collective.** The part of `read_stored` after reading.
std::string wrong_checksum(const Communicator& comm, const std::filesystem::path& path,
                           const std::vector<SlabReader::Check>& checks);

template <class Read>
std::string read_stored(const Communicator& comm, const std::filesystem::path& path, Read read) {
    std::vector<SlabReader::Check> checks;
    std::string reason;
    try {
        SlabReader reader(path);
        read(reader);
        checks = reader.checks();
    } catch (const std::exception& failure) {
        reason = path.string() + ": " + failure.what();
    }
    reason = comm.first_error(reason);
    return reason.empty() ? wrong_checksum(comm, path, checks) : reason;
}

} // namespace nappe
