#pragma once
// The small file beside a stored sample or checkpoint. It is written last, and read first: HDF5 1.10.8 crashes or hangs on
// some damaged files, so a file is opened only when its length and checksum are those of the manifest. Everything here is
// Local.

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <string>

namespace nappe {

/// Counted up whenever a change of the code changes a bit of what it computes from a stored state: samples are then made
/// anew, checkpoints refused.
inline constexpr std::int64_t physics_revision = 3;

struct StoredManifest {
    std::uint64_t key = 0; ///< of what the file was made from
    std::int64_t physics_revision = 0;
    std::int64_t n_grains = 0;
    std::int64_t n_contacts = 0;
    std::uint64_t file_bytes = 0;
    std::uint64_t file_checksum = 0; ///< io/checksum.hpp
    nlohmann::ordered_json notes;
};

/// JSON with a checksum of itself.
std::string format_manifest(const StoredManifest& manifest);

/// Throws std::runtime_error with the reason if the text is not a whole manifest.
StoredManifest parse_manifest(const std::string& text);

/// The tree of a text, or a discarded one if it is no JSON or nested deeper than anything we write.
nlohmann::ordered_json parse_shallow(const std::string& text);

/// FOLDER/NAME.hdf has its manifest in FOLDER/NAME.json.
std::filesystem::path manifest_path(std::filesystem::path file);

/// The whole of a text file. Throws SystemError.
std::string read_text(const std::filesystem::path& path);

} // namespace nappe
