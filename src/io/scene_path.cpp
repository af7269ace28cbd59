#include "io/scene_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <set>

namespace nappe::scene_file {

namespace {

std::optional<std::string> name_of(const toml::node& element) {
    const auto* table = element.as_table();
    const auto* name = table != nullptr ? table->get_as<std::string>("name") : nullptr;
    if (name == nullptr || !is_name(name->get())) {
        return std::nullopt;
    }
    return name->get();
}

std::optional<std::size_t> index_of(std::string_view segment) {
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(segment.data(), segment.data() + segment.size(), index);
    if (error != std::errc() || end != segment.data() + segment.size()) {
        return std::nullopt;
    }
    return index;
}

/// Bytes of the character of UTF-8 that the text starts with; 0 if it starts with none.
std::size_t character_length(std::string_view text) {
    const auto lead = static_cast<unsigned char>(text[0]);
    const std::size_t length = lead < 0x80   ? 1
                               : lead < 0xC2 ? 0
                               : lead < 0xE0 ? 2
                               : lead < 0xF0 ? 3
                               : lead < 0xF5 ? 4
                                             : 0;
    const auto follows = [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; };
    const bool whole = length <= text.size() && length > 0 &&
                       std::all_of(text.begin() + 1, text.begin() + static_cast<std::ptrdiff_t>(length), follows);
    return whole ? length : 0;
}

} // namespace

std::vector<std::string> split_path(std::string_view path) {
    std::vector<std::string> segments;
    if (path.empty()) {
        return segments;
    }
    std::size_t start = 0;
    for (std::size_t dot = path.find('.'); dot != std::string_view::npos; dot = path.find('.', start)) {
        segments.emplace_back(path.substr(start, dot - start));
        start = dot + 1;
    }
    segments.emplace_back(path.substr(start));
    return segments;
}

bool is_name(std::string_view text) {
    const auto allowed = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    };
    return !text.empty() && text.size() <= 64 && std::all_of(text.begin(), text.end(), allowed);
}

const toml::node* find_child(const toml::node& parent, std::string_view segment) {
    if (const auto* table = parent.as_table()) {
        return table->get(segment);
    }
    const auto* array = parent.as_array();
    if (array == nullptr) {
        return nullptr;
    }
    for (const auto& element : *array) {
        if (name_of(element) == segment) {
            return &element;
        }
    }
    const auto index = index_of(segment);
    return index ? array->get(*index) : nullptr;
}

toml::node* find_child(toml::node& parent, std::string_view segment) {
    return const_cast<toml::node*>(find_child(std::as_const(parent), segment));
}

std::vector<std::string> child_names(const toml::node& parent) {
    std::vector<std::string> names;
    if (const auto* table = parent.as_table()) {
        for (const auto& [key, node] : *table) {
            names.emplace_back(key.str());
        }
    } else if (const auto* array = parent.as_array()) {
        names = element_labels(*array);
    }
    return names;
}

std::vector<std::string> element_labels(const toml::array& array) {
    std::vector<std::string> labels;
    std::set<std::string> taken;
    for (const auto& element : array) {
        const auto name = name_of(element);
        labels.push_back(name && taken.insert(*name).second ? *name : std::to_string(labels.size()));
    }
    return labels;
}

std::string join_path(std::string_view path, std::string_view segment) {
    return path.empty() ? std::string(segment) : fmt::format("{}.{}", path, segment);
}

std::string one_line(std::string_view text, std::size_t most) {
    std::string line;
    for (std::size_t i = 0; i < text.size();) {
        const auto length = character_length(text.substr(i));
        if (line.size() + std::max<std::size_t>(length, 1) > most) {
            return line + "…";
        }
        if (length == 0) {
            line += '?';
        } else if (const auto first = static_cast<unsigned char>(text[i]); first < 0x20 || first == 0x7F) {
            line += ' ';
        } else {
            line += text.substr(i, length);
        }
        i += std::max<std::size_t>(length, 1);
    }
    return line;
}

std::string shown(const toml::node& node) {
    if (const auto* text = node.as_string()) {
        return fmt::format("\"{}\"", one_line(text->get()));
    }
    if (const auto* number = node.as_floating_point()) {
        // 80.0 keeps its point: it may be just what is wrong with it.
        const auto digits = fmt::format("{}", number->get());
        return digits.find_first_not_of("-0123456789") == std::string::npos ? digits + ".0" : digits;
    }
    if (const auto* number = node.as_integer()) {
        return fmt::format("{}", number->get());
    }
    if (const auto* flag = node.as_boolean()) {
        return flag->get() ? "true" : "false";
    }
    if (const auto* array = node.as_array()) {
        return array->size() == 1 ? "an array of 1 value" : fmt::format("an array of {} values", array->size());
    }
    return node.is_table() ? "a table" : "a date or time";
}

} // namespace nappe::scene_file
