#include "io/scene_path.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

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
        for (std::size_t i = 0; i < array->size(); ++i) {
            names.push_back(element_label(*array, i));
        }
    }
    return names;
}

std::string element_label(const toml::array& array, std::size_t i) {
    const auto name = name_of(*array.get(i));
    const bool meant = name && find_child(array, *name) == array.get(i);
    return meant ? *name : std::to_string(i);
}

std::string join_path(std::string_view path, std::string_view segment) {
    return path.empty() ? std::string(segment) : fmt::format("{}.{}", path, segment);
}

std::string shown(const toml::node& node) {
    if (const auto* text = node.as_string()) {
        return fmt::format("\"{}\"", text->get());
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
