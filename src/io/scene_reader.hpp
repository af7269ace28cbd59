#pragma once
// Scene files: TOML in, a Scene with every rule checked out. docs/scene.md documents the keys.

#include "core/scene.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace nappe {

/// KEY=VALUE over a scene's keys, and where it was said, for messages.
struct SceneOverride {
    std::string text;
    std::string place; ///< "FILE:LINE: NAME"; empty: the command line, "--set KEY=VALUE"
};

/// The text of a TOML file. Local. Throws InputError if there is no such file, or if it is a directory, or empty.
/// @param kind "scene" @param help where an example stands
std::string read_input_text(const std::string& path, std::string_view kind, std::string_view help);

/// The text of a scene file. Rank 0 reads it and broadcasts it, so that all ranks parse the same bytes. Local. Throws
/// InputError if there is no such file, or if it is a directory, or empty.
std::string read_scene_text(const std::string& path);

/// The scene that `text` describes, after the overrides (KEY=VALUE, in order). `file_name` is only for messages.
/// Scene::text is the scene as run; it parses again to the same Scene. Local. Throws InputError with one line per
/// problem: FILE:LINE: KEY: rule, value found; remedy.
Scene<2> parse_scene(std::string_view text, std::string_view file_name, const std::vector<std::string>& overrides = {});

/// The same with overrides that were not said on the command line.
Scene<2> parse_scene_with(std::string_view text, std::string_view file_name,
                          const std::vector<SceneOverride>& overrides);

/// Both in one, for a single process. Local. Throws InputError.
Scene<2> read_scene(const std::string& path, const std::vector<std::string>& overrides = {});

} // namespace nappe
