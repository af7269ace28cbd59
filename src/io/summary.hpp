#pragma once
// DIR/summary.json, and the texts that reports share. Everything here is Local, for rank 0.

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace nappe {

/// "0.1.0", as the build has it.
std::string_view program_version();

/// 16 hex digits: state hashes, sample keys, checksums.
std::string hex_digits(std::uint64_t value);

/// Indented, with a newline at the end; numbers in the fewest digits that read back to the same bits; NaN and
/// infinities as null, bytes that are no UTF-8 as U+FFFD.
std::string format_summary(const nlohmann::ordered_json& summary);

/// What a file that anybody may have edited says under a key; `otherwise` if it says nothing there, or something of another
/// kind.
template <class T>
T value_of(const nlohmann::ordered_json& json, const std::string& key, const T& otherwise) {
    try {
        return json.is_object() ? json.value(key, otherwise) : otherwise;
    } catch (const nlohmann::json::exception&) {
        return otherwise;
    }
}

/// Writes the file atomically. Throws SystemError.
void write_summary(const std::filesystem::path& path, const nlohmann::ordered_json& summary);

} // namespace nappe
