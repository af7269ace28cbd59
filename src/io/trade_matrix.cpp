#include "io/trade_matrix.hpp"

#include "io/scene_path.hpp"
#include "io/scene_reader.hpp"
#include "io/scene_sections.hpp"
#include "io/scene_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

namespace nappe {

namespace {

using namespace scene_file;

constexpr auto reference_name = "reference";

/// A value as --set takes it, on one line.
std::string value_text(const toml::node& node) {
    if (node.is_number()) {
        return shown(node); // in the fewest digits
    }
    auto flags = toml::toml_formatter::default_flags;
    flags &= ~toml::format_flags::allow_multi_line_strings;
    flags &= ~toml::format_flags::indentation;
    std::ostringstream stream;
    node.visit([&](const auto& concrete) { stream << toml::toml_formatter(concrete, flags); });
    auto text = stream.str();
    std::replace(text.begin(), text.end(), '\n', ' '); // between the elements of a long array
    return text;
}

/// The values below a table, by dotted path: { output = { front_bin = 2 } } is output.front_bin = 2 and leaves the
/// scene's other keys of output alone.
void gather(const toml::table& table, const std::string& path, const std::string& file, const std::string& setting,
            std::vector<TradeKey>& keys) {
    for (const auto& [key, node] : table) {
        const auto below = join_path(path, key.str());
        if (const auto* inner = node.as_table()) {
            gather(*inner, below, file, setting, keys);
        } else {
            keys.push_back(
                {below, value_text(node), fmt::format("{}:{}: {}", file, node.source().begin.line, setting)});
        }
    }
}

void read_keys(const TableReader& table, std::string_view key, const std::string& file, const std::string& setting,
               std::string_view remedy, std::vector<TradeKey>& keys) {
    if (!table.has(key)) {
        return;
    }
    if (const auto* values = table.find(key)->as_table()) {
        gather(*values, "", file, setting, keys);
    } else {
        table.problem(key, "must be a table", remedy);
    }
}

TradeSetting read_setting(const TableReader& table, const std::string& name, const toml::node& node,
                          const std::string& file) {
    TradeSetting setting;
    setting.name = name;
    setting.place = fmt::format("{}:{}: {}", file, node.source().begin.line, table.path());
    read_keys(table, "solver", file, table.path(), "write solver = { sweeps = 30 }", setting.solver);
    read_keys(table, "set", file, table.path(), "write set = { \"tiles.skin\" = 0.3 }", setting.set);
    for (const auto& key : setting.set) {
        const bool how_often = key.key.starts_with("output.frames.") || key.key.starts_with("output.series.");
        if (key.key == "sample.seed") {
            table.problem("set", "must leave the sample's seed alone", "list seeds at the top of the matrix");
        } else if (key.key.starts_with("output") && !how_often) {
            table.problem("set", "must leave output alone but for output.frames and output.series",
                          "what is measured must be the same for all settings; change the scene, or use --set");
        }
    }
    return setting;
}

void read_seeds(const TableReader& top, std::vector<std::int64_t>& seeds) {
    constexpr auto remedy = "write seeds = [1, 2, 3]";
    if (!top.has("seeds")) {
        return;
    }
    const auto* array = top.find("seeds")->as_array();
    if (array == nullptr || array->empty()) {
        top.problem("seeds", "must be an array of at least one integer", remedy);
        return;
    }
    for (std::size_t i = 0; i < array->size(); ++i) {
        const auto* seed = array->get(i)->as_integer();
        const auto key = fmt::format("seeds.{}", i);
        if (seed == nullptr || seed->get() < 0) {
            top.problem(key, "must be an integer >= 0", remedy);
        } else if (std::find(seeds.begin(), seeds.end(), seed->get()) != seeds.end()) {
            top.problem(key, "must be listed once", "a run repeated is the same run; remove it");
        } else {
            seeds.push_back(seed->get());
        }
    }
}

void read_settings(const TableReader& top, const std::string& file, TradeMatrix& matrix) {
    if (const auto table = top.table("reference", "[reference]", "write [reference] with a solver far tighter than all",
                                     Need::required)) {
        matrix.reference = read_setting(*table, reference_name, *top.find("reference"), file);
    }
    const auto tables = top.tables("settings", "[[settings]]", "write [[settings]]");
    if (tables.empty() && (!top.has("settings") || top.find("settings")->is_array())) {
        top.problem("settings", "must hold at least one setting", "write [[settings]] with a name and a solver");
    }
    std::vector<std::string> names;
    for (std::size_t i = 0; i < tables.size(); ++i) {
        const auto name = read_name(tables[i], names, "setting");
        if (name == reference_name) {
            tables[i].problem("name", "must not be that of the reference", "rename it: runs are kept by this name");
        }
        names.push_back(name);
        // Elements that are no tables have no reader, so the place may be that of a neighbour; then it is never shown.
        matrix.settings.push_back(read_setting(tables[i], name, *top.find("settings")->as_array()->get(i), file));
    }
}

} // namespace

std::string read_matrix_text(const std::string& path) {
    return read_input_text(path, "matrix", "docs/accuracy.md has an example");
}

TradeMatrix parse_matrix(std::string_view text, std::string_view file_name) {
    const toml::table root = parse_toml(text, file_name);
    Problems problems(root, file_name);
    const TableReader top(root, "", "matrix", problems);
    TradeMatrix matrix;
    matrix.text = text;
    read_seeds(top, matrix.seeds);
    top.read("window", matrix.window, {0, 1, true, "", "give the share of loading over which to average"});
    double duration = 0;
    if (top.read("duration", duration, positive("s", "give the loading time to run"))) {
        matrix.duration = duration;
    }
    int frames = 0;
    if (top.read("frames", frames, {1, "give the number of frames of each run"})) {
        matrix.frames = frames;
    }
    read_settings(top, std::string(file_name), matrix);
    problems.throw_if_any();
    return matrix;
}

} // namespace nappe
