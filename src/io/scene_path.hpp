#pragma once
// Dotted paths into a scene file: tables by key, elements of arrays by their `name` or by index from 0, as in
// walls.piston.motion.velocity or laws.0.friction. Messages and --set use the same paths. Internal to src/io.

#include <toml++/toml.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace nappe::scene_file {

/// "a.b.c" taken apart; "" gives no segments. Local.
std::vector<std::string> split_path(std::string_view path);

/// Letters, digits, _ and -, 1 to 64 of them: fit for a file name and for a path. Local.
bool is_name(std::string_view text);

/// The node below `parent` that the segment means, or nullptr. Local.
const toml::node* find_child(const toml::node& parent, std::string_view segment);
toml::node* find_child(toml::node& parent, std::string_view segment);

/// What the segments below `parent` may be: keys of a table, names or indices of an array. Local.
std::vector<std::string> child_names(const toml::node& parent);

/// How element i of an array is called in messages: its name if it has one that no earlier element has, else i. Local.
std::string element_label(const toml::array& array, std::size_t i);

/// path.segment, or the segment alone at the top. Local.
std::string join_path(std::string_view path, std::string_view segment);

/// A value as messages show it: 0.5, "text", a table, an array of 3 values. Local.
std::string shown(const toml::node& node);

} // namespace nappe::scene_file
