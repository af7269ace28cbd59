#pragma once
// --set KEY=VALUE: values of a scene file replaced from the command line. Internal to src/io.

#include <toml++/toml.h>

#include <string>

namespace nappe::scene_file {

/// Puts one "KEY=VALUE" into the scene. KEY is a path (io/scene_path.hpp) whose last parts may be new: whether the scene
/// knows them is for the reader to say. VALUE is a TOML value, or a bare word for a string. The nodes put in carry
/// their place as their source, for messages: `said_at`, or "--set KEY=VALUE" if that is empty. Local. Throws InputError.
void apply_override(toml::table& root, const std::string& text, const std::string& said_at = "");

} // namespace nappe::scene_file
