#pragma once
// The small file beside a stored sample. It is written last, and read first: HDF5 1.10.8 crashes or hangs on some
// damaged files, so a file is opened only when its length and checksum are those of the manifest. Everything here is
// Local.

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <string>

namespace nappe {

struct SampleManifest {
    std::uint64_t key = 0;
    std::int64_t physics_revision = 0;
    std::int64_t n_grains = 0;
    std::int64_t n_contacts = 0;
    std::uint64_t file_bytes = 0;
    std::uint64_t file_checksum = 0; ///< io/checksum.hpp
    nlohmann::ordered_json notes;
};

/// JSON with a checksum of itself.
std::string format_manifest(const SampleManifest& manifest);

/// Throws std::runtime_error with the reason if the text is not a whole manifest of this key.
SampleManifest parse_manifest(const std::string& text, std::uint64_t key);

/// The whole of a text file. Throws SystemError.
std::string read_text(const std::filesystem::path& path);

} // namespace nappe
