#include "io/stored_rows.hpp"

#include "core/error.hpp"
#include "io/atomic_file.hpp"
#include "io/checksum.hpp"
#include "io/hdf5_writer.hpp"

#include <fmt/format.h>

namespace nappe {

namespace {

constexpr const char* offsets_path = "/grains/first_contact";

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

/// Length and checksum of the file against the manifest; the reason not to use it, or nothing. Collective.
std::string damage(const Communicator& comm, const std::filesystem::path& path, const StoredManifest& manifest) {
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

void add_text(const Communicator& comm, const char* path, const std::string& text, Hdf5Content& content) {
    if (!text.empty()) {
        const std::string mine = comm.is_root() ? text : std::string();
        content.add<std::uint8_t>(path, by_root(comm, text.size()), mine,
                                  [](char c) { return static_cast<std::uint8_t>(c); });
    }
}

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

void add_checksums(const Communicator& comm, Hdf5Content& content) {
    for (const auto& dataset : content.datasets) {
        const auto mine = row_checksum(dataset.bytes, dataset.row_bytes(), dataset.range.first);
        content.attributes.push_back({dataset.path, "checksum", comm.sum_wrapping(mine)});
    }
}

void write_stored(const Communicator& comm, const std::filesystem::path& path, const Hdf5Content& content,
                  StoredManifest manifest) {
    on_root(comm, [&] { std::filesystem::create_directories(path.parent_path()); });
    write_hdf5(comm, path, content);
    manifest.file_checksum = file_checksum(comm, path);
    on_root(comm, [&] {
        manifest.file_bytes = std::filesystem::file_size(path);
        write_file_atomically(manifest_path(path), format_manifest(manifest));
    });
}

StoredFile examine_stored(const Communicator& comm, const std::filesystem::path& path) {
    std::string text, reason;
    if (comm.is_root()) {
        try {
            text = read_text(manifest_path(path));
            parse_manifest(text);
        } catch (const std::exception& failure) {
            reason = failure.what();
        }
    }
    reason = comm.first_error(reason);
    if (!reason.empty()) {
        return {{}, reason};
    }
    comm.broadcast(text);
    StoredFile file{parse_manifest(text), {}};
    file.reason = damage(comm, path, file.manifest);
    return file;
}

void SlabReader::remember(const std::string& path, std::span<const std::byte> bytes, std::size_t row_bytes,
                          std::int64_t first) {
    checks_.push_back({path, file_.bits(path, "checksum"), row_checksum(bytes, row_bytes, first)});
}

void SlabReader::expect_rows(const StoredManifest& manifest) const {
    for (const auto& [path, rows] :
         {std::pair("/grains/id", manifest.n_grains), {"/contacts/lo", manifest.n_contacts}}) {
        if (const auto found = file_.stored_rows(path); found != rows) {
            throw Hdf5Failure(fmt::format("dataset {} has {} rows, the manifest says {}", path, found, rows));
        }
    }
}

std::string SlabReader::read_text(const Communicator& comm, const char* path) {
    if (!file_.has(path)) {
        return {};
    }
    const auto bytes = read_shared<std::uint8_t>(comm, path, 1, file_.rows(path));
    return {bytes.begin(), bytes.end()};
}

template <int D>
std::vector<ContactRow<D>> SlabReader::read_contacts(std::int64_t first, std::int64_t count, bool last_rank) {
    auto offsets = read<std::int64_t>(offsets_path, 1, first, count + (last_rank ? 1 : 0));
    if (!last_rank) {
        offsets.push_back(file_.read<std::int64_t>(offsets_path, first + count, 1).front());
    }
    const auto stored = file_.stored_rows("/contacts/lo");
    std::int64_t before = first == 0 ? 0 : offsets.front();
    for (const auto offset : offsets) {
        if (offset < before || offset > stored) {
            throw std::runtime_error(fmt::format("dataset {} must ascend from 0 to {}, found {} after {}", offsets_path,
                                                 stored, offset, before));
        }
        before = offset;
    }
    if ((first == 0 && offsets.front() != 0) || (last_rank && offsets.back() != stored)) {
        throw std::runtime_error(fmt::format("dataset {} must ascend from 0 to {}, found {} … {}", offsets_path, stored,
                                             offsets.front(), offsets.back()));
    }
    std::vector<ContactRow<D>> contacts(static_cast<std::size_t>(offsets.back() - offsets.front()));
    visit_contact_fields<D>(filling(*this, offsets.front(), contacts));
    return contacts;
}

std::string wrong_checksum(const Communicator& comm, const std::filesystem::path& path,
                           const std::vector<SlabReader::Check>& checks) {
    for (const auto& check : checks) {
        if (comm.sum_wrapping(check.mine) != check.expected) {
            return fmt::format("{}: dataset {} is damaged", path.string(), check.path);
        }
    }
    return {};
}

template void add_offsets<2>(const Communicator&, const RowRange&, const RowRange&, const std::vector<ContactRow<2>>&,
                             Hdf5Content&);
template std::vector<ContactRow<2>> SlabReader::read_contacts<2>(std::int64_t, std::int64_t, bool);

} // namespace nappe
