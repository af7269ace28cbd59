#include "commands/restart_rules.hpp"

#include "core/error.hpp"
#include "core/large_grains.hpp"
#include "io/checksum.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

namespace nappe {

namespace {

/// A key of the scene, and all that it says, in one canonical text.
struct Part {
    std::string key;
    std::string text;
};

std::string text_of(const Vec<2>& p) {
    return fmt::format("[{}, {}]", p[0], p[1]);
}

std::string text_of(const std::vector<Vec<2>>& points) {
    std::string text;
    for (const auto& p : points) {
        text += text_of(p);
    }
    return text;
}

std::vector<Part> parts_of(const Scene<2>& scene) {
    std::vector<Part> parts;
    std::string text;
    for (const auto& m : scene.materials) {
        text += fmt::format("{} {}\n", m.name, m.density);
    }
    parts.push_back({"materials (names and densities)", text});
    text.clear();
    if (scene.sample) {
        const auto& s = *scene.sample;
        text = fmt::format("{} {} {} {} {} {} {} {}", static_cast<int>(s.arrangement), s.material,
                           static_cast<int>(s.radii.kind), s.radii.min, s.radii.max, s.seed,
                           fmt::join(s.layer_tops, " "), text_of(s.profile));
    }
    parts.push_back({"sample", text});
    text.clear();
    for (const auto& g : scene.grains) {
        text += fmt::format("{} {} {} {} {} {}\n", g.material, g.radius, text_of(g.position), text_of(g.velocity),
                            g.spin[0], g.layer);
        text += g.drop ? "dropped\n" : "";
    }
    parts.push_back({"grains", text});
    text.clear();
    for (const auto& w : scene.walls) {
        text += fmt::format("{} {} {}\n", w.name, w.material, text_of(w.points));
    }
    parts.push_back({"walls (names, materials and points)", text});
    text.clear();
    for (const auto& s : scene.stages) {
        text += fmt::format("{} {}\n", s.name, s.until.has_value());
    }
    parts.push_back({"stages (names and kinds)", text});
    text.clear();
    for (const auto& c : scene.output.cells) {
        text += fmt::format("{} {} {}\n", c.name, text_of(c.centre), c.radius);
    }
    parts.push_back({"output.cells", text});
    text.clear();
    for (const auto& g : scene.output.gauges) {
        text += fmt::format("{} {} {} {} {} {}\n", g.name, g.wall, g.from, g.to, g.bins, g.every);
    }
    parts.push_back({"output.gauges", text});
    text.clear();
    for (const auto& p : scene.output.probes) {
        text += fmt::format("{} {} {}\n", p.name, p.grain, p.every);
    }
    parts.push_back({"output.probes", text});
    parts.push_back({"tiles", fmt::format("{} {} {}", scene.tiles.side, scene.tiles.skin, scene.tiles.lookahead)});
    if (has_large_grains(scene)) { // scenes without them keep the key they had
        parts.push_back({"tiles.large_above", fmt::format("{}", large_above(scene))});
    }
    parts.push_back({"world.origin", text_of(scene.origin)});
    return parts;
}

} // namespace

std::uint64_t restart_key(const Scene<2>& scene) {
    std::string all;
    for (const auto& part : parts_of(scene)) {
        all += part.key + "\n" + part.text + "\n";
    }
    return checksum(all);
}

void check_restart(const Scene<2>& before, const Scene<2>& now, const SnapshotClock& clock) {
    const auto was = parts_of(before), is = parts_of(now);
    for (std::size_t k = 0; k < was.size(); ++k) {
        if (was[k].text != is[k].text) {
            throw InputError(fmt::format("--set: {} must be what the run began with, since the checkpoint holds their "
                                         "state; leave it away, or run the scene anew",
                                         was[k].key));
        }
    }
    if (before.output.measures.energy != now.output.measures.energy) {
        throw InputError(
            fmt::format("--set: output.measures.energy must be {} as the run began, since series/energy.csv has "
                        "its columns; leave it away",
                        before.output.measures.energy));
    }
    if (now.output.measures.energy && loads_springs(before) != loads_springs(now)) {
        throw InputError(fmt::format("--set: {} stage may have method = \"cundall\" as the run began, since "
                                     "series/energy.csv has the columns of that; leave it away",
                                     loads_springs(before) ? "some loading" : "no loading"));
    }
    const auto stage_in_hand = static_cast<std::size_t>(clock.stage);
    for (std::size_t k = 0; k <= stage_in_hand; ++k) {
        const auto &old = before.stages[k], &next = now.stages[k];
        if (old.solver.h != next.solver.h) {
            throw InputError(fmt::format("--set: solver.h of stage '{}' must be {} s as the run began it, found {} s; "
                                         "leave it away, or change solver.substeps",
                                         old.name, old.solver.h, next.solver.h));
        }
        if (!old.until && k < stage_in_hand && n_steps(old) != n_steps(next)) {
            throw InputError(
                fmt::format("--set: the duration of stage '{}' must be {} s, since it is over, found {} s; "
                            "leave it away",
                            old.name, old.duration, next.duration));
        }
    }
    const auto& stage = now.stages[stage_in_hand];
    if (!stage.until && n_steps(stage) < clock.stage_steps) {
        throw InputError(fmt::format(
            "--set: the duration of stage '{}' must not end before the checkpoint, at step {} of "
            "it, found {} s; give it {} s or more",
            stage.name, clock.stage_steps, stage.duration, static_cast<double>(clock.stage_steps) * stage.solver.h));
    }
}

} // namespace nappe
