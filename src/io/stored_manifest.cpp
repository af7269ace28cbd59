#include "io/stored_manifest.hpp"

#include "core/error.hpp"
#include "io/bounded_read.hpp"
#include "io/checksum.hpp"
#include "io/summary.hpp"

#include <fmt/format.h>

#include <charconv>
#include <fstream>
#include <stdexcept>

namespace nappe {

namespace {

/// Raised when the datasets of stored files change.
constexpr int format_version = 1;

/// No manifest is longer, nor nested deeper (what is nested is written and taken down by recursion).
constexpr std::size_t most_bytes = std::size_t{16} << 20;
constexpr int deepest = 32;

[[noreturn]] void wrong(const char* key, const char* rule) {
    throw std::runtime_error(fmt::format("the manifest's {} must be {}", key, rule));
}

std::uint64_t hex_at(const nlohmann::ordered_json& json, const char* key) {
    const auto at = json.find(key);
    const auto* text = at != json.end() ? at->get_ptr<const std::string*>() : nullptr;
    std::uint64_t value = 0;
    if (text == nullptr || text->size() != 16 ||
        std::from_chars(text->data(), text->data() + text->size(), value, 16).ptr != text->data() + text->size()) {
        wrong(key, "16 hexadecimal digits");
    }
    return value;
}

std::int64_t count_at(const nlohmann::ordered_json& json, const char* key) {
    const auto at = json.find(key);
    if (at == json.end() || !at->is_number_integer() || (at->is_number_unsigned() && at->get<std::uint64_t>() >> 62) ||
        at->get<std::int64_t>() < 0) {
        wrong(key, "a whole number >= 0");
    }
    return at->get<std::int64_t>();
}

} // namespace

nlohmann::ordered_json parse_shallow(const std::string& text) {
    bool shallow = true;
    const auto keep = [&](int depth, nlohmann::ordered_json::parse_event_t, nlohmann::ordered_json&) {
        shallow = shallow && depth <= deepest;
        return shallow;
    };
    auto json = nlohmann::ordered_json::parse(text, keep, false);
    return shallow ? json : nlohmann::ordered_json(nlohmann::ordered_json::value_t::discarded);
}

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
    auto json = parse_shallow(text);
    std::string stored;
    if (json.is_object() && json.contains("manifest_checksum")) {
        stored = json["manifest_checksum"].dump();
        json.erase("manifest_checksum");
    }
    if (stored.empty() || stored != nlohmann::ordered_json(hex_digits(checksum(format_summary(json)))).dump()) {
        throw std::runtime_error("the manifest is damaged");
    }
    if (!json.contains("format") || json["format"] != format_version) {
        throw std::runtime_error("the manifest is of another version of nappe");
    }
    StoredManifest manifest;
    manifest.key = hex_at(json, "key");
    manifest.physics_revision = count_at(json, "physics_revision");
    manifest.n_grains = count_at(json, "n_grains");
    manifest.n_contacts = count_at(json, "n_contacts");
    manifest.file_bytes = static_cast<std::uint64_t>(count_at(json, "file_bytes"));
    manifest.file_checksum = hex_at(json, "file_checksum");
    if (!json.contains("notes") || !(json["notes"].is_object() || json["notes"].is_null())) {
        wrong("notes", "a table");
    }
    manifest.notes = json["notes"];
    // An id takes 8 bytes: whoever makes room for that many rows makes no more than a few times the file's length.
    const auto most_rows = static_cast<std::int64_t>(manifest.file_bytes / sizeof(std::int64_t));
    if (manifest.n_grains > most_rows || manifest.n_contacts > most_rows) {
        wrong("n_grains and n_contacts", "no more than a file of its file_bytes can hold");
    }
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
    auto text = read_at_most(in, most_bytes);
    if (text.size() > most_bytes) {
        throw SystemError(fmt::format("{} is longer than any manifest, {} MiB", path.string(), most_bytes >> 20));
    }
    return text;
}

} // namespace nappe
