#include "io/scene_reader.hpp"

#include "core/error.hpp"
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
#include <iterator>
#include <sstream>

namespace nappe {

namespace {

toml::table parse_toml(std::string_view text, std::string_view file_name) {
    try {
        return toml::parse(text, file_name);
    } catch (const toml::parse_error& error) {
        throw InputError(fmt::format("{}:{}: must be valid TOML: {} (column {}); see https://toml.io", file_name,
                                     error.source().begin.line, error.description(), error.source().begin.column));
    }
}

std::string formatted(const toml::table& root) {
    std::ostringstream stream;
    stream << toml::toml_formatter(root) << '\n';
    return stream.str();
}

} // namespace

std::string read_scene_text(const std::string& path) {
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) {
        throw InputError(fmt::format("{}: must be a scene file, found a directory; name the .toml file in it", path));
    }
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    if (!file) {
        throw InputError(
            fmt::format("{}: must be a readable scene file, found: {}; check the path", path, std::strerror(errno)));
    }
    std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    if (file.bad()) {
        throw InputError(fmt::format("{}: must be a readable scene file, found an error while reading", path));
    }
    if (text.find_first_not_of(" \t\r\n") == std::string::npos) {
        throw InputError(fmt::format("{}: must hold a scene, found an empty file; docs/scene.md has an example", path));
    }
    return text;
}

Scene<2> parse_scene(std::string_view text, std::string_view file_name, const std::vector<std::string>& overrides) {
    toml::table root = parse_toml(text, file_name);
    for (const auto& override_text : overrides) {
        scene_file::apply_override(root, override_text);
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

Scene<2> read_scene(const std::string& path, const std::vector<std::string>& overrides) {
    return parse_scene(read_scene_text(path), path, overrides);
}

} // namespace nappe
