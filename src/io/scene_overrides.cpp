#include "io/scene_overrides.hpp"

#include "core/error.hpp"
#include "io/scene_keys.hpp"
#include "io/scene_path.hpp"
#include "io/scene_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace nappe::scene_file {

namespace {

std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(" \t");
    return first == std::string_view::npos ? "" : text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// A document of exactly one (dotted) key; none if the value is not TOML, or is more than a value.
std::optional<toml::table> parse_one(const std::string& key, std::string_view value, const std::string& place) {
    if (value.find_first_of("\n\r") != std::string_view::npos) {
        return std::nullopt;
    }
    try {
        return std::optional<toml::table>(parse_toml(fmt::format("{} = {}", key, value), place));
    } catch (const InputError&) {
        return std::nullopt;
    }
}

toml::table parse_value(const std::string& key, std::string_view value, const std::string& place) {
    auto document = parse_one(key, value, place);
    if (!document && is_name(value)) {
        document = parse_one(key, fmt::format("\"{}\"", value), place);
    }
    if (!document) {
        throw InputError(fmt::format("{}: the value must be TOML on one line (0.5, true, [1, 0], {{ every = 10 }}, "
                                     "\"text\" or a bare word), found {}; mind the shell's own quotes",
                                     place, value.empty() ? "nothing" : fmt::format("\"{}\"", one_line(value))));
    }
    return std::move(*document);
}

[[noreturn]] void no_such_element(const std::string& place, const std::string& path, const toml::node& parent,
                                  const std::string& segment) {
    const auto names = child_names(parent);
    const auto meant = nearest(segment, names);
    const auto remedy =
        meant ? fmt::format("did you mean {}?", *meant) : std::string("add it in the file, or replace the whole array");
    throw InputError(fmt::format("{}: {}: must name an element of {} ({}) or give its index from 0, found \"{}\"; {}",
                                 place, join_path(path, segment), path, names.empty() ? "it is empty" : listed(names),
                                 segment, remedy));
}

} // namespace

void apply_override(toml::table& root, const std::string& text, const std::string& said_at) {
    const std::string place = said_at.empty() ? "--set " + one_line(text) : said_at;
    const auto equals = text.find('=');
    const auto key = trimmed(std::string_view(text).substr(0, equals));
    const auto segments = split_path(key);
    bool good = equals != std::string::npos && !segments.empty() && segments.size() <= deepest_path;
    for (const auto& segment : segments) {
        good = good && is_name(segment);
    }
    if (!good) {
        throw InputError(
            fmt::format("{}: must be KEY=VALUE with a dotted KEY of letters, digits, _ and -, found \"{}\"; "
                        "for example --set solver.h=0.01 or walls.piston.motion.velocity=[1,0]",
                        place, one_line(text)));
    }
    const auto value = trimmed(std::string_view(text).substr(equals + 1));

    toml::node* parent = &root;
    std::size_t depth = 0;
    std::string path;
    while (depth + 1 < segments.size()) {
        toml::node* child = find_child(*parent, segments[depth]);
        if (child == nullptr) {
            break;
        }
        parent = child;
        path = join_path(path, segments[depth++]);
    }

    if (auto* table = parent->as_table()) {
        std::string rest;
        for (std::size_t i = depth; i < segments.size(); ++i) {
            rest = join_path(rest, segments[i]);
        }
        auto document = parse_value(rest, value, place);
        const auto first = document.begin(); // kept: what it points to lives inside the iterator
        first->second.visit([&](auto& concrete) { table->insert_or_assign(first->first, std::move(concrete)); });
    } else if (auto* array = parent->as_array()) {
        const toml::node* old = find_child(*parent, segments[depth]);
        if (old == nullptr || depth + 1 < segments.size()) {
            no_such_element(place, path, *parent, segments[depth]);
        }
        std::size_t index = 0;
        while (array->get(index) != old) {
            ++index;
        }
        auto document = parse_value("value", value, place);
        const auto first = document.begin();
        first->second.visit([&](auto& concrete) {
            array->replace(array->cbegin() + static_cast<std::ptrdiff_t>(index), std::move(concrete));
        });
    } else {
        throw InputError(fmt::format("{}: {}: must be a table or an array to hold \"{}\", found {}; shorten the key",
                                     place, path, segments[depth], shown(*parent)));
    }
}

} // namespace nappe::scene_file
