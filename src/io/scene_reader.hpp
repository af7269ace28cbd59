#pragma once
// Scene files: TOML in, a Scene with every rule checked out. docs/scene.md documents the keys.

#include "core/scene.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace nappe {

/// The text of a scene file. Rank 0 reads it and broadcasts it, so that all ranks parse the same bytes. Local. Throws
/// InputError if there is no such file, or if it is a directory, or empty.
std::string read_scene_text(const std::string& path);

/// The scene that `text` describes, after the overrides (KEY=VALUE, in order). `file_name` is only for messages.
/// Scene::text is the scene as run; it parses again to the same Scene. Local. Throws InputError with one line per
/// problem: FILE:LINE: KEY: rule, value found; remedy.
Scene<2> parse_scene(std::string_view text, std::string_view file_name, const std::vector<std::string>& overrides = {});

/// Both in one, for a single process. Local. Throws InputError.
Scene<2> read_scene(const std::string& path, const std::vector<std::string>& overrides = {});

} // namespace nappe
