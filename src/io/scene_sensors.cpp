// What is recorded at intervals of its own: gauges along walls, probes of single grains.
#include "io/scene_keys.hpp"
#include "io/scene_sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace nappe::scene_file {

namespace {

constexpr int most_bins = 10000; ///< columns of a series are twice as many

double length_of(const Wall<2>& wall) {
    double length = 0;
    for (std::size_t k = 1; k < wall.points.size(); ++k) {
        length += (wall.points[k] - wall.points[k - 1]).norm();
    }
    return length;
}

} // namespace

bool read_wall(const TableReader& table, const Scene<2>& scene, std::string_view remedy, int& wall) {
    std::string name;
    std::vector<std::string> names;
    for (const auto& known : scene.walls) {
        names.push_back(known.name);
    }
    if (!table.read("wall", name, remedy, Need::required)) {
        return false;
    }
    const auto found = std::find(names.begin(), names.end(), name);
    wall = static_cast<int>(found - names.begin());
    if (found == names.end()) {
        const auto meant = nearest(name, names);
        table.problem("wall",
                      fmt::format("must name a wall of the scene ({})", names.empty() ? "it has none" : listed(names)),
                      meant ? fmt::format("did you mean {}?", *meant) : "define the wall first");
        return false;
    }
    return true;
}

void read_gauges(const TableReader& output, Scene<2>& scene) {
    std::vector<std::string> names;
    for (const auto& table :
         output.tables("gauges", "output.gauges", "write [{ name = \"slab\", wall = \"floor\", bins = 10 }]")) {
        Gauge gauge;
        gauge.name = read_name(table, names, "gauge");
        names.push_back(gauge.name);
        table.read("from", gauge.from, not_negative("m", "give the way along the wall from its first point"));
        table.read("bins", gauge.bins, {1, "give the number of bins of equal width", most_bins});
        table.read("every", gauge.every, {1, "give it in steps"});
        if (!read_wall(table, scene, "name the wall that the gauges are in", gauge.wall)) {
            continue;
        }
        const double length = length_of(scene.walls[static_cast<std::size_t>(gauge.wall)]);
        gauge.to = length;
        table.read("to", gauge.to, positive("m", "give the way along the wall from its first point"));
        const double most = length * (1 + 1e-9);
        if (gauge.to > most || gauge.from > most) {
            table.problem(gauge.to > most ? "to" : "from",
                          fmt::format("must be at most {} [m], the length of wall {}", length,
                                      scene.walls[static_cast<std::size_t>(gauge.wall)].name),
                          "leave it out for the whole wall");
        } else if (!(gauge.from < gauge.to)) {
            table.problem("from", fmt::format("must be < {} [m], where the gauges end", gauge.to), "exchange the two");
        }
        if (gauge.to >= length * (1 - 1e-9)) {
            gauge.to = length;
        }
        scene.output.gauges.push_back(gauge);
    }
}

void read_probes(const TableReader& output, Scene<2>& scene) {
    std::vector<std::string> names;
    for (const auto& table : output.tables("probes", "output.probes", "write [{ name = \"block\", grain = 0 }]")) {
        Probe probe;
        probe.name = read_name(table, names, "probe");
        names.push_back(probe.name);
        table.read(
            "grain", probe.grain,
            {-1000000000,
             "give the id of the grain: those of the sample come first, then those of [[grains]]; or -1 for the last",
             std::numeric_limits<std::int64_t>::max()},
            Need::required);
        probe.place = table.place_of("grain");
        table.read("every", probe.every, {1, "give it in steps"});
        scene.output.probes.push_back(probe);
    }
}

} // namespace nappe::scene_file
