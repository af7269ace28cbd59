#pragma once
// The sections of a scene file, one function each: keys to fields, names to indices. Internal to src/io.

#include "core/scene.hpp"
#include "io/scene_table.hpp"

namespace nappe::scene_file {

/// Reads all sections; whatever is wrong is added to `problems`, and then the scene returned is incomplete. Rules that
/// look at several sections are checked afterwards (io/scene_rules.hpp). Local.
Scene<2> read_sections(const toml::table& root, Problems& problems);

// Parts of it (io/scene_matter.cpp: what the scene is made of; io/scene_course.cpp: what happens to it). Each reads its
// own table below `top`; materials come before whatever is made of them, stages before walls that move with them.
void read_materials(const TableReader& top, Scene<2>& scene);
void read_laws(const TableReader& top, Scene<2>& scene);
void read_sample(const TableReader& top, Scene<2>& scene);
void read_grains(const TableReader& top, Scene<2>& scene);
void read_walls(const TableReader& top, Scene<2>& scene);
void read_stages(const TableReader& top, Scene<2>& scene);
void read_tiles(const TableReader& top, Scene<2>& scene);
void read_balance(const TableReader& top, Scene<2>& scene);
void read_watch(const TableReader& top, Scene<2>& scene); // io/scene_watch.cpp
void read_output(const TableReader& top, Scene<2>& scene);
void read_gauges(const TableReader& output, Scene<2>& scene); // io/scene_sensors.cpp
void read_probes(const TableReader& output, Scene<2>& scene);

/// The key `wall` of a table as an index of scene.walls; false, and a problem added, if it names none.
bool read_wall(const TableReader& table, const Scene<2>& scene, std::string_view remedy, int& wall);

/// The element's name; a problem if an earlier element has it too, "" and a problem if it is none. `kind` for the message: "wall". Local.
std::string read_name(const TableReader& element, const std::vector<std::string>& taken, std::string_view kind);

} // namespace nappe::scene_file
