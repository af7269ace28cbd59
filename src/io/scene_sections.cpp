#include "io/scene_sections.hpp"

#include "io/scene_path.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace nappe::scene_file {

namespace {

constexpr std::size_t longest_title = 200;

/// False if the rest can not be read as a scene in the plane.
bool read_world(const TableReader& top, Scene<2>& scene) {
    const auto world = top.table("world", "[world]", "write [world]");
    if (!world) {
        return true;
    }
    int dimension = 2;
    const bool plane =
        world->read("dimension", dimension, {2, "only scenes in the plane are built; leave it out or write 2", 2});
    if (!plane && world->has("dimension")) {
        return false;
    }
    world->read("gravity", scene.gravity, any_real("m/s²", "give [0, -9.81] for the Earth's"));
    world->read("origin", scene.origin,
                any_real("m", "give the point that positions are computed from, a corner of the tiles"));
    return true;
}

/// From the coordinates of files to those of a scene. Exact where the difference is a double: always for an origin of
/// [0, 0]; far from there, where coordinates have few binary digits.
void to_origin(Scene<2>& scene) {
    const Vec<2>& origin = scene.origin;
    if (scene.sample) {
        for (auto& p : scene.sample->profile) {
            p -= origin;
        }
        for (double& top : scene.sample->layer_tops) {
            top -= origin[1];
        }
    }
    for (auto& grain : scene.grains) {
        grain.position -= origin;
    }
    for (auto& wall : scene.walls) {
        for (auto& p : wall.points) {
            p -= origin;
        }
    }
    for (auto& cell : scene.output.cells) {
        cell.centre -= origin;
    }
    if (scene.output.zone) {
        scene.output.zone->tip -= origin;
    }
    if (scene.watch.bounds) {
        scene.watch.bounds->min -= origin;
        scene.watch.bounds->max -= origin;
    }
}

} // namespace

std::string read_name(const TableReader& element, const std::vector<std::string>& taken, std::string_view kind) {
    std::string name;
    const auto remedy = fmt::format("name the {}: files and --set use the name", kind);
    if (!element.read("name", name, remedy, Need::required)) {
        return "";
    }
    if (!is_name(name)) {
        element.problem("name", "must be 1 to 64 letters, digits, _ or -", "files are named after it");
        return "";
    }
    if (std::find(taken.begin(), taken.end(), name) != taken.end()) {
        element.problem("name", fmt::format("must be the only {} of that name", kind), "rename one of them");
    }
    return name;
}

Scene<2> read_sections(const toml::table& root, Problems& problems) {
    Scene<2> scene;
    const TableReader top(root, "", "top level", problems);
    constexpr auto title_remedy = "one line for pictures and logs";
    if (top.read("title", scene.title, title_remedy) && one_line(scene.title, longest_title) != scene.title) {
        top.problem("title", fmt::format("must be one line of at most {} bytes", longest_title), title_remedy);
    }
    if (!read_world(top, scene)) {
        return scene;
    }
    read_materials(top, scene);
    read_laws(top, scene);
    read_sample(top, scene);
    read_grains(top, scene);
    read_stages(top, scene);
    read_walls(top, scene);
    read_tiles(top, scene);
    read_balance(top, scene);
    read_watch(top, scene);
    read_output(top, scene);
    to_origin(scene);
    return scene;
}

} // namespace nappe::scene_file
