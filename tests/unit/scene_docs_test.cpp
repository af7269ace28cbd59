// docs/scene.md against the reader: its keys, its example, and what it says that named accuracies choose.
#include "scene_fields.hpp"

#include "core/error.hpp"
#include "io/scene_keys.hpp"
#include "io/scene_reader.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>

namespace nappe {
namespace {

const std::string docs = std::string(NAPPE_SOURCE_DIR) + "/docs/scene.md";

/// key -> the table whose heading it stands under, as "table key" lines, from the rows "| `key` |" of docs/scene.md.
std::vector<std::string> documented_keys() {
    std::ifstream file(docs);
    std::vector<std::string> found;
    std::string table;
    for (std::string line; std::getline(file, line);) {
        const auto open = line.find('`');
        const auto close = line.find('`', open + 1);
        if (open == std::string::npos || close == std::string::npos) {
            table = line.starts_with("## ") ? line.substr(3) : table;
            continue;
        }
        const auto code = line.substr(open + 1, close - open - 1);
        if (line.starts_with("## ")) {
            table = code;
        } else if (line.starts_with("| `")) {
            found.push_back(table + " " + code);
        }
    }
    return found;
}

TEST(scene_docs, docs_list_the_keys_that_the_reader_knows_and_no_others) {
    std::vector<std::string> known;
    for (const auto& table : scene_file::all_keys()) {
        for (const auto& key : table.keys) {
            known.push_back(fmt::format("{} {}", table.table, key));
        }
    }
    auto documented = documented_keys();
    std::sort(known.begin(), known.end());
    std::sort(documented.begin(), documented.end());
    EXPECT_EQ(documented, known);
}

TEST(scene_docs, the_example_of_the_docs_is_sound) {
    std::ifstream file(docs);
    std::ostringstream all;
    all << file.rdbuf();
    const auto text = all.str();
    const auto start = text.find("```toml\n");
    ASSERT_NE(start, std::string::npos);
    const auto end = text.find("```\n", start + 8);
    EXPECT_NO_THROW(parse_scene(text.substr(start + 8, end - start - 8), "scene.md"));
}

/// Accuracy -> "key = value, …" of the list in docs/scene.md.
std::map<std::string, std::string> documented_accuracies() {
    std::ifstream file(docs);
    std::map<std::string, std::string> found;
    for (std::string line; std::getline(file, line);) {
        for (const std::string name : {"fast", "balanced", "tight"}) {
            if (!line.starts_with("- `\"" + name + "\"`:")) {
                continue;
            }
            auto& keys = found[name];
            for (auto at = line.find('`', line.find(':')); at != std::string::npos;) {
                const auto end = line.find('`', at + 1);
                keys += (keys.empty() ? "" : ", ") + line.substr(at + 1, end - at - 1);
                at = line.find('`', end + 1);
            }
        }
    }
    return found;
}

/// A scene that settles and falls. @param top of the file @param solver of the stage that falls @param base of all
std::string scene_with(const std::string& top, const std::string& solver, const std::string& base = "") {
    return test::fields(
        parse_scene(fmt::format(R"({}
materials.rock.density = 1
laws = [{{ between = ["rock", "rock"], type = "{}", friction = 0 }}]
grains = [{{ material = "rock", radius = 1, position = [0, 0] }}]
stages = [{{ name = "settle", until = {{ kinetic = 1e-8, residual = 1e-4, at_most = 10 }} }},
          {{ name = "fall", duration = 1, solver = {{ {} }} }}]
solver.h = 0.1
{})",
                                top, base.find("gamma") == std::string::npos ? "frictional" : "cohesive", solver, base),
                    "accuracy.toml"));
}

/// A scene that says the listed keys itself, for the stage with a duration, is the same scene.
TEST(scene_docs, named_accuracies_choose_what_is_listed) {
    const auto listed = documented_accuracies();
    ASSERT_EQ(listed.size(), 3u);
    for (const auto& [name, keys] : listed) {
        EXPECT_EQ(scene_with("accuracy = \"" + name + "\"", ""), scene_with("", keys)) << name;
        EXPECT_NE(scene_with("accuracy = \"" + name + "\"", ""), scene_with("", "")) << name;
    }
}

/// What [solver] says goes before, and quiet tiles are asked only of sweeps that have them.
TEST(scene_docs, named_accuracies_leave_room) {
    EXPECT_EQ(scene_with("accuracy = \"tight\"", "", "solver.substeps = 6"),
              scene_with("accuracy = \"tight\"", "substeps = 6", "solver.substeps = 6"));
    EXPECT_EQ(scene_with("accuracy = \"balanced\"", "method = \"ansgs\""),
              scene_with("", "method = \"ansgs\", substeps = 10, geometry_every = 10, position_correction = 0.8"));
    EXPECT_EQ(scene_with("accuracy = \"balanced\"", "", "solver.precision = \"single\""),
              scene_with("", "substeps = 10, geometry_every = 10, position_correction = 0.8",
                         "solver.precision = \"single\""));
    const std::string cohesive = "materials.rock.gamma = 1e3\nmaterials.rock.d_w = 0.01\n";
    EXPECT_EQ(scene_with("accuracy = \"balanced\"", "", cohesive),
              scene_with("", "substeps = 10, geometry_every = 10, adaptive = 3e-3", cohesive));
    EXPECT_THROW(scene_with("accuracy = \"balanced\"", "method = \"ansgs\", adaptive = 1e-2"), InputError);
}

} // namespace
} // namespace nappe
