#pragma once
// Dotted paths into a scene file: tables by key, elements of arrays by their `name` or by index from 0, as in
// walls.piston.motion.velocity or laws.0.friction. Messages and --set use the same paths. Internal to src/io.

#include <toml++/toml.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace nappe::scene_file {

/// Segments of a path; no key lies deeper.
inline constexpr std::size_t deepest_path = 16;

/// "a.b.c" taken apart; "" gives no segments. Local.
std::vector<std::string> split_path(std::string_view path);

/// Letters, digits, _ and -, 1 to 64 of them: fit for a file name and for a path. Local.
bool is_name(std::string_view text);

/// The node below `parent` that the segment means, or nullptr. Local.
const toml::node* find_child(const toml::node& parent, std::string_view segment);
toml::node* find_child(toml::node& parent, std::string_view segment);

/// What the segments below `parent` may be: keys of a table, names or indices of an array. Local.
std::vector<std::string> child_names(const toml::node& parent);

/// How the elements of an array are called in messages: by name if they have one that no earlier element has, else by
/// index. Local.
std::vector<std::string> element_labels(const toml::array& array);

/// path.segment, or the segment alone at the top. Local.
std::string join_path(std::string_view path, std::string_view segment);

/// Fit for a message, whatever was typed: on one line, without what is no UTF-8 or no character, at most `most` bytes.
std::string one_line(std::string_view text, std::size_t most = 100);

/// A value as messages show it: 0.5, "text", a table, an array of 3 values. Local.
std::string shown(const toml::node& node);

} // namespace nappe::scene_file
