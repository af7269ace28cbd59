#pragma once
// Keys whose value is one of a few names. Internal to src/io.

#include "io/scene_table.hpp"

#include <fmt/format.h>

#include <initializer_list>
#include <string>
#include <utility>

namespace nappe::scene_file {

/// `target` is left alone, and a problem added, if the value is none of the names. Local.
template <class E>
void read_choice(const TableReader& table, std::string_view key,
                 std::initializer_list<std::pair<const char*, E>> choices, E& target) {
    std::string names;
    std::size_t k = 0;
    for (const auto& choice : choices) {
        names += fmt::format("{}\"{}\"", k == 0 ? "" : k + 1 == choices.size() ? " or " : ", ", choice.first);
        ++k;
    }
    const auto remedy = fmt::format("write {}", names);
    std::string name;
    if (!table.read(key, name, remedy)) {
        return;
    }
    for (const auto& [known, value] : choices) {
        if (name == known) {
            target = value;
            return;
        }
    }
    table.problem(key, fmt::format("must be {}", names), remedy);
}

} // namespace nappe::scene_file
