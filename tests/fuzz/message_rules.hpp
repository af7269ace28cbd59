#pragma once
// What every message about bad input must be like, whoever gives it.

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

namespace nappe::fuzz {

inline constexpr std::size_t longest_line = 2000; ///< bytes: a screenful, whatever the input holds

/// Whether the bytes are UTF-8 without control characters other than line feeds.
inline bool is_plain_text(std::string_view text) {
    for (std::size_t i = 0; i < text.size();) {
        const auto lead = static_cast<unsigned char>(text[i]);
        const std::size_t length = lead < 0x80 ? 1 : lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : lead >= 0xC2 ? 2 : 0;
        if (length == 0 || lead > 0xF4 || (lead < 0x20 && lead != '\n') || lead == 0x7F || i + length > text.size()) {
            return false;
        }
        for (std::size_t k = 1; k < length; ++k) {
            if ((static_cast<unsigned char>(text[i + k]) & 0xC0U) != 0x80U) {
                return false;
            }
        }
        i += length;
    }
    return true;
}

/// What is wrong with any text meant for a user; "" if nothing is. Library names and HDF5's own error stack never show,
/// unless the input itself speaks of them.
inline std::string fault_of_text(std::string_view text, std::string_view input) {
    if (text.empty()) {
        return "is empty";
    }
    if (!is_plain_text(text)) {
        return "is no plain UTF-8";
    }
    for (const auto* raw : {"basic_string", "std::", "bad_alloc", "vector::", "map::", "HDF5-DIAG", "json.exception",
                            "stoi", "stoull", "terminate"}) {
        if (text.find(raw) != std::string_view::npos && input.find(raw) == std::string_view::npos) {
            return std::string("speaks of ") + raw;
        }
    }
    for (std::size_t start = 0; start <= text.size();) {
        const auto end = std::min(text.find('\n', start), text.size());
        if (end == start || end - start > longest_line) {
            return end == start ? "has an empty line" : "has an endless line";
        }
        start = end + 1;
    }
    return "";
}

/// What is wrong with one line of a message about a scene: it starts with the place (file and line, file alone for what
/// has no line, or the override), then says the key, the rule ("must …"), the value found and the remedy.
inline std::string fault_of_scene_line(std::string_view line, std::string_view file) {
    if (line.starts_with("… and ")) {
        return "";
    }
    std::size_t at = 0;
    if (line.starts_with("--set ")) {
        at = line.find(": ", 6);
    } else if (line.starts_with(file)) {
        at = line.find(": ", file.size());
        const auto number = line.substr(file.size(), at - file.size());
        if (!number.empty() &&
            (number.size() < 2 || number[0] != ':' ||
             number.find_first_not_of("0123456789", 1) != std::string_view::npos || number[1] == '0')) {
            return "has no sound line number";
        }
    } else {
        return "does not start with its place";
    }
    const auto rule = line.find("must ", at);
    const auto found = line.find(", found", rule);
    if (at == std::string_view::npos || rule == std::string_view::npos) {
        return "has no rule";
    }
    if (found == std::string_view::npos) {
        return "has no value found";
    }
    if (line.find("; ", found) == std::string_view::npos) {
        return "has no remedy";
    }
    return "";
}

/// The same of a whole message.
inline std::string fault_of_scene_message(std::string_view text, std::string_view file, std::string_view input) {
    auto fault = fault_of_text(text, input);
    for (std::size_t start = 0; fault.empty() && start < text.size();) {
        const auto end = std::min(text.find('\n', start), text.size());
        fault = fault_of_scene_line(text.substr(start, end - start), file);
        start = end + 1;
    }
    return fault;
}

} // namespace nappe::fuzz
