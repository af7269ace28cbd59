#include "io/stored_manifest.hpp"

#include "core/error.hpp"
#include "io/checksum.hpp"
#include "io/summary.hpp"

#include <fstream>
#include <iterator>
#include <stdexcept>

namespace nappe {

namespace {

/// Raised when the datasets of stored files change.
constexpr int format_version = 1;

std::uint64_t parse_hex(const nlohmann::ordered_json& text) {
    return std::stoull(text.get<std::string>(), nullptr, 16);
}

} // namespace

std::string format_manifest(const StoredManifest& manifest) {
    nlohmann::ordered_json json;
    json["format"] = format_version;
    json["key"] = hex_digits(manifest.key);
    json["physics_revision"] = manifest.physics_revision;
    json["n_grains"] = manifest.n_grains;
    json["n_contacts"] = manifest.n_contacts;
    json["file_bytes"] = manifest.file_bytes;
    json["file_checksum"] = hex_digits(manifest.file_checksum);
    json["notes"] = manifest.notes;
    json["manifest_checksum"] = hex_digits(checksum(format_summary(json)));
    return format_summary(json);
}

StoredManifest parse_manifest(const std::string& text) {
    auto json = nlohmann::ordered_json::parse(text, nullptr, false);
    std::string stored;
    if (json.is_object() && json.contains("manifest_checksum")) {
        stored = json["manifest_checksum"].dump();
        json.erase("manifest_checksum");
    }
    if (stored != nlohmann::ordered_json(hex_digits(checksum(format_summary(json)))).dump()) {
        throw std::runtime_error("the manifest is damaged");
    }
    if (json.at("format") != format_version) {
        throw std::runtime_error("the manifest is of another version of nappe");
    }
    StoredManifest manifest;
    manifest.key = parse_hex(json.at("key"));
    manifest.physics_revision = json.at("physics_revision").get<std::int64_t>();
    manifest.n_grains = json.at("n_grains").get<std::int64_t>();
    manifest.n_contacts = json.at("n_contacts").get<std::int64_t>();
    manifest.file_bytes = json.at("file_bytes").get<std::uint64_t>();
    manifest.file_checksum = parse_hex(json.at("file_checksum"));
    manifest.notes = json.at("notes");
    return manifest;
}

std::filesystem::path manifest_path(std::filesystem::path file) {
    return file.replace_extension(".json");
}

std::string read_text(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    if (!in) {
        throw SystemError(path.string() + " is not there or can not be read");
    }
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

} // namespace nappe
