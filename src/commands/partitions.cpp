#include "commands/partitions.hpp"

#include "commands/partitions_tiles.hpp"
#include "commands/prepare.hpp"
#include "core/contact_geometry.hpp"
#include "core/error.hpp"
#include "core/initial_grains.hpp"
#include "io/atomic_file.hpp"
#include "io/sample_store.hpp"
#include "io/scene_reader.hpp"
#include "io/summary.hpp"
#include "parallel/tile_graph.hpp"
#include "solver/simulation.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

namespace nappe {

namespace {

/// Contacts that a step would pack if everything stood still: those nearer than 1 % of the radii.
std::vector<std::int64_t> relaxations_at_rest(const Simulation<2>& simulation) {
    const auto& state = simulation.state();
    const auto& candidates = simulation.candidates();
    std::vector<std::int64_t> relaxations;
    for (const auto& tile : candidates.plain_tiles()) {
        std::int64_t n = 0;
        for (auto c = static_cast<std::size_t>(tile.candidates_begin);
             c < static_cast<std::size_t>(tile.candidates_end); ++c) {
            const LocalId a = candidates.a[c], b = candidates.b[c];
            const auto g = contact_geometry(state, simulation.walls(), a, b);
            const double size = state.radius[a] + (b < state.n_held() ? state.radius[b] : state.radius[a]);
            n += g.applies && g.gap <= 0.01 * size ? 1 : 0;
        }
        relaxations.push_back(n);
    }
    return relaxations;
}

struct Range {
    double mean = 0;
    double most = 0;

    void add(double value, std::size_t n) {
        mean += value / static_cast<double>(n);
        most = std::max(most, value);
    }
};

/// One line of the table, of a sweep.
std::string line(std::int32_t n_parts, double cut_seconds, const PartitionCounts<2>& counts) {
    const auto n = counts.parts.size();
    std::vector<std::int64_t> messages(n, 0), sent(n, 0), neighbours(n, 0);
    std::vector<std::vector<std::int32_t>> heard(n);
    for (const auto& m : counts.messages) {
        const auto from = static_cast<std::size_t>(m.from);
        messages[from] += 1;
        sent[from] += m.grains * bytes_per_sent_grain<2>;
        heard[from].push_back(m.to);
    }
    Range tiles, work, message, bytes, neighbour;
    double interface = 0, by_colour = 0;
    std::array<std::int64_t, n_tile_colours<2>> most_of{};
    for (std::size_t p = 0; p < n; ++p) {
        const auto& part = counts.parts[p];
        std::sort(heard[p].begin(), heard[p].end());
        const auto distinct = std::unique(heard[p].begin(), heard[p].end()) - heard[p].begin();
        tiles.add(static_cast<double>(part.tiles), n);
        work.add(static_cast<double>(part.relaxations()), n);
        message.add(static_cast<double>(messages[p]), n);
        bytes.add(static_cast<double>(sent[p]), n);
        neighbour.add(static_cast<double>(distinct), n);
        for (std::size_t c = 0; c < most_of.size(); ++c) {
            interface += static_cast<double>(part.interface[c]);
            most_of[c] = std::max(most_of[c], part.interface[c] + part.interior[c]);
        }
    }
    for (const auto most : most_of) {
        by_colour += static_cast<double>(most);
    }
    const double mean = std::max(work.mean, 1e-300);
    return fmt::format("{:>5} {:>9.1f} {:>11.1f} {:>9.3f} {:>9.3f} {:>9.3f} {:>7.1f} {:>4.0f} {:>9.0f} {:>8.0f} "
                       "{:>6.2f} {:>3.0f} {:>6.2f}\n",
                       n_parts, tiles.mean, work.mean, work.most / mean, by_colour / mean,
                       interface / (mean * static_cast<double>(n)), message.mean, message.most, bytes.mean, bytes.most,
                       neighbour.mean, neighbour.most, cut_seconds);
}

constexpr const char* heading = "parts     tiles relaxations   largest by colour interface   messages         bytes   "
                                "      neighbours    cut\n"
                                "         a part      a part  over mean over mean     share    mean most      mean     "
                                "most   mean most      s\n";

nlohmann::ordered_json to_json(std::int32_t n_parts, double cut_seconds, const PartitionCounts<2>& counts) {
    nlohmann::ordered_json json;
    json["parts"] = n_parts;
    json["cut_seconds"] = cut_seconds;
    for (const auto& part : counts.parts) {
        json["tiles"].push_back(part.tiles);
        json["grains"].push_back(part.grains);
        json["interface"].push_back(part.interface);
        json["interior"].push_back(part.interior);
    }
    auto& messages = json["messages"];
    for (const char* column : {"from", "colour", "to", "grains"}) {
        messages[column] = nlohmann::ordered_json::array();
    }
    for (const auto& m : counts.messages) {
        messages["from"].push_back(m.from);
        messages["colour"].push_back(m.colour);
        messages["to"].push_back(m.to);
        messages["grains"].push_back(m.grains);
    }
    return json;
}

/// One way of counting one sample, cut into every number of parts.
struct Counted {
    const char* level; ///< "grains" or "tiles"
    double scale;      ///< of the scene's lengths
    double grains;
    TileGraph graph;
};

template <class Count>
nlohmann::ordered_json count_all(const Counted& sample, const std::vector<std::int32_t>& parts, Count&& count) {
    std::int64_t relaxations = 0;
    for (const auto w : sample.graph.weight) {
        relaxations += w;
    }
    fmt::print("\ncounted by {}: {:.0f} grains, {} relaxations a sweep, {} tiles\n{}", sample.level, sample.grains,
               relaxations, sample.graph.keys.size(), heading);
    nlohmann::ordered_json json;
    json["level"] = sample.level;
    json["scale"] = sample.scale;
    json["grains"] = sample.grains;
    json["relaxations"] = relaxations;
    json["tiles"] = sample.graph.keys.size();
    json["cuts"] = nlohmann::ordered_json::array();
    for (const auto n : parts) {
        const auto start = std::chrono::steady_clock::now();
        const auto part = partition(sample.graph, n);
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        const auto counts = count(part, n);
        fmt::print("{}", line(n, seconds, counts));
        std::fflush(stdout);
        json["cuts"].push_back(to_json(n, seconds, counts));
    }
    return json;
}

void check_options(const Communicator& comm, const PartitionsOptions& options) {
    if (comm.size() > 1) {
        throw InputError(fmt::format("nappe partitions: takes one rank, whatever number it cuts for, found {}; start "
                                     "it without mpirun",
                                     comm.size()));
    }
    for (const auto n : options.parts) {
        if (n < 1) {
            throw InputError(fmt::format("--parts: must be >= 1, found {}; give numbers of ranks: 1,2,4", n));
        }
    }
    const auto in_range = [](double scale) { return std::isfinite(scale) && scale > 0; };
    if (!in_range(options.scale)) {
        throw InputError(fmt::format("--scale: must be > 0, found {}; give a factor of lengths", options.scale));
    }
    if (options.tile_scale != 0 && !in_range(options.tile_scale)) {
        throw InputError(fmt::format("--tile-scale: must be > 0, found {}; give a factor of lengths, or leave it away",
                                     options.tile_scale));
    }
}

/// The scene's grains at rest, with their candidates.
void load(Simulation<2>& simulation, const PartitionsOptions& options) {
    const auto& scene = simulation.scene();
    const auto& solver = scene.stages.front().solver;
    const double h = solver.h / solver.substeps;
    if (options.samples.empty()) {
        simulation.load(initial_grains(scene), {}, h);
    } else {
        const auto found = load_sample<2>(simulation.comm(), options.samples, sample_origin(scene), row_limits(scene));
        if (!found.sample) {
            throw InputError(fmt::format("--samples: must hold the scene's settled sample, found none in {} ({}); run "
                                         "the scene once with the same --samples, or leave it away for the deposit",
                                         options.samples.string(), found.reason));
        }
        simulation.load(found.sample->grains, found.sample->contacts, h);
    }
    simulation.start_stage(0);
}

} // namespace

Scene<2> scaled(Scene<2> scene, double scale) {
    if (scene.sample) {
        for (auto& p : scene.sample->profile) {
            p *= scale;
        }
    }
    for (auto& wall : scene.walls) {
        for (auto& p : wall.points) {
            p *= scale;
        }
    }
    return scene;
}

void partitions(const Communicator& comm, const PartitionsOptions& options) {
    check_options(comm, options);
    const auto scene = scaled(read_scene(options.scene, options.overrides), options.scale);
    if (options.tile_scale > 0 && !scene.sample) {
        throw InputError("--tile-scale: takes a scene with a [sample], found none; its profile gives the tiles");
    }
    Simulation<2> simulation(comm, scene, disk_kernels(nullptr));
    load(simulation, options);
    const auto& state = simulation.state();
    const auto& candidates = simulation.candidates();
    const auto& grid = simulation.domain().grid();
    const auto relaxations = relaxations_at_rest(simulation);

    nlohmann::ordered_json json;
    json["version"] = program_version();
    json["scene"] = scene.text;
    json["tile_side"] = grid.side();
    json["bytes_per_grain"] = bytes_per_sent_grain<2>;

    std::vector<TileWork> work;
    for (std::size_t t = 0; t < candidates.plain_tiles().size(); ++t) {
        work.push_back({candidates.plain_tiles()[t].key, relaxations[t]});
    }
    const Counted made{"grains", options.scale, static_cast<double>(state.n_own),
                       tile_graph<2>(work, tile_links(state, grid, candidates))};
    json["counts"].push_back(count_all(made, options.parts, [&](const auto& part, std::int32_t n) {
        TileDirectory directory;
        directory.assign(made.graph.keys, part);
        return count_partition<2>(state, grid, candidates, relaxations, directory, n);
    }));

    if (options.tile_scale > 0) {
        const double r = scene.sample->radii.min;
        const double least_area = std::numbers::pi * r * r;
        const auto tiles = fill_profile(scene.sample->profile, grid, least_area);
        const auto mean = measure_tiles(state, grid, candidates, relaxations, tiles);
        // The sample itself first: what counting by tiles is worth shows against the counts above.
        std::vector<double> scales = {1.0};
        if (options.tile_scale != 1) {
            scales.push_back(options.tile_scale);
        }
        for (const double scale : scales) {
            const auto larger = fill_profile(scaled(scene, scale).sample->profile, grid, least_area);
            double grains = 0;
            for (const auto& tile : larger) {
                grains += tile.fill * mean.grains;
            }
            const Counted expected{"tiles", options.scale * scale, grains, tile_graph(mean, larger)};
            json["counts"].push_back(count_all(expected, options.parts, [&](const auto& part, std::int32_t n) {
                return count_partition(mean, larger, part, n);
            }));
        }
    }
    if (!options.json.empty()) {
        write_file_atomically(options.json, json.dump() + "\n");
    }
}

} // namespace nappe
