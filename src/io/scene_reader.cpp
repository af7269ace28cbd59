#include "io/scene_reader.hpp"

#include "core/error.hpp"
#include "io/bounded_read.hpp"
#include "io/scene_overrides.hpp"
#include "io/scene_rules.hpp"
#include "io/scene_sections.hpp"
#include "io/scene_table.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace nappe {

namespace {

using scene_file::parse_toml;

std::string formatted(const toml::table& root) {
    std::ostringstream stream;
    stream << toml::toml_formatter(root) << '\n';
    return stream.str();
}

} // namespace

std::string read_input_text(const std::string& path, std::string_view kind, std::string_view help) {
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) {
        throw InputError(
            fmt::format("{}: must be a {} file, found a directory; name the .toml file in it", path, kind));
    }
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        throw InputError(
            fmt::format("{}: must be a readable {} file, found: {}; check the path", path, kind, std::strerror(errno)));
    }
    // What never ends (/dev/zero) must not be read to its end; in memory a tree of TOML is some thirty times its text.
    constexpr std::size_t most = std::size_t{64} << 20;
    auto text = read_at_most(file, most);
    if (file.bad()) {
        throw InputError(
            fmt::format("{}: must be a readable {} file, found an error while reading; check the disk", path, kind));
    }
    if (text.size() > most) {
        throw InputError(fmt::format("{}: must be a {} file of at most {} MiB, found more; is it the right file?", path,
                                     kind, most >> 20));
    }
    if (text.find_first_not_of(" \t\r\n") == std::string::npos) {
        throw InputError(fmt::format("{}: must hold a {}, found an empty file; {}", path, kind, help));
    }
    return text;
}

std::string read_scene_text(const std::string& path) {
    return read_input_text(path, "scene", "docs/scene.md has an example");
}

Scene<2> parse_scene_with(std::string_view text, std::string_view file_name,
                          const std::vector<SceneOverride>& overrides) {
    toml::table root = parse_toml(text, file_name);
    for (const auto& override_text : overrides) {
        scene_file::apply_override(root, override_text.text, override_text.place);
    }
    scene_file::Problems problems(root, file_name);
    Scene<2> scene = scene_file::read_sections(root, problems);
    // The rules across sections would only repeat, or misread, what is wrong within one.
    problems.throw_if_any();
    scene_file::check_rules(scene, problems);
    problems.throw_if_any();
    scene.text = formatted(root);
    return scene;
}

Scene<2> parse_scene(std::string_view text, std::string_view file_name, const std::vector<std::string>& overrides) {
    std::vector<SceneOverride> placed;
    placed.reserve(overrides.size());
    for (const auto& override_text : overrides) {
        placed.push_back({override_text, ""});
    }
    return parse_scene_with(text, file_name, placed);
}

Scene<2> read_scene(const std::string& path, const std::vector<std::string>& overrides) {
    return parse_scene(read_scene_text(path), path, overrides);
}

} // namespace nappe
