#include "io/scene_keys.hpp"

#include <algorithm>
#include <cstddef>
#include <stdexcept>

namespace nappe::scene_file {

const std::vector<TableKeys>& all_keys() {
    static const std::vector<TableKeys> keys = {
        {"top level",
         {"title", "accuracy", "world", "materials", "laws", "sample", "grains", "walls", "stages", "solver", "tiles",
          "balance", "watch", "output"}},
        {"[world]", {"dimension", "gravity", "origin"}},
        {"[materials.NAME]", {"density", "gamma", "d_w", "damping", "spin_damping"}},
        {"[[laws]]", {"between", "type", "friction", "restitution", "gamma", "d_w", "k_n", "k_s", "c_n", "c_s"}},
        {"[sample]", {"material", "arrangement", "radius", "profile", "layers", "seed"}},
        {"sample.radius", {"law", "min", "max", "value"}},
        {"sample.layers", {"count", "from", "to"}},
        {"[[grains]]", {"material", "radius", "position", "velocity", "spin", "layer", "drop"}},
        {"[[walls]]", {"name", "points", "material", "motion"}},
        {"walls.motion", {"stage", "start", "velocity", "stop"}},
        {"[[stages]]", {"name", "until", "duration", "solver"}},
        {"stages.until", {"kinetic", "residual", "unbalanced", "at_most"}},
        {"[solver]",
         {"method", "h", "theta", "sweeps", "tolerance", "max_sweeps", "check_every", "substeps", "geometry_every",
          "adaptive", "position_correction", "warm_start", "at_max", "coupling", "precision", "unsafe"}},
        {"[tiles]", {"side", "skin", "lookahead", "large_above"}},
        {"[balance]", {"threshold", "every", "by", "moves"}},
        {"[watch]", {"overlap", "energy", "residual", "bounds", "failure", "max_substeps"}},
        {"watch.overlap", {"limit", "do"}},
        {"watch.energy", {"limit", "do"}},
        {"watch.residual", {"steps", "do"}},
        {"watch.bounds", {"min", "max", "do"}},
        {"watch.failure", {"do"}},
        {"[output]", {"frames", "series", "cells", "gauges", "probes", "front_bin", "measures", "zone"}},
        {"output.frames", {"every"}},
        {"output.series", {"every"}},
        {"output.cells", {"name", "centre", "radius"}},
        {"output.gauges", {"name", "wall", "from", "to", "bins", "every"}},
        {"output.probes", {"name", "grain", "every"}},
        {"output.measures", {"during_run", "spacing", "range", "energy"}},
        {"output.zone", {"wall", "tip", "tolerance"}},
    };
    return keys;
}

const std::vector<TableKeys>& matrix_keys() {
    static const std::vector<TableKeys> keys = {
        {"matrix", {"seeds", "window", "duration", "frames", "reference", "settings"}},
        {"[reference]", {"solver", "set"}},
        {"[[settings]]", {"name", "solver", "set"}},
    };
    return keys;
}

const TableKeys& keys_of(std::string_view table) {
    for (const auto* keys : {&all_keys(), &matrix_keys()}) {
        for (const auto& entry : *keys) {
            if (entry.table == table) {
                return entry;
            }
        }
    }
    throw std::logic_error("no such table in scene_keys.cpp: " + std::string(table));
}

namespace {

/// Insertions, deletions and replacements that turn one word into the other.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) {
        row[j] = j;
    }
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
        }
    }
    return row.back();
}

} // namespace

std::optional<std::string> nearest(std::string_view word, const std::vector<std::string>& candidates) {
    std::optional<std::string> best;
    // A third of the letters wrong is still a typo; more is another word.
    std::size_t limit = std::max<std::size_t>(1, word.size() / 3) + 1;
    for (const auto& candidate : candidates) {
        const std::size_t distance = edit_distance(word, candidate);
        if (distance < limit && distance < candidate.size()) {
            best = candidate;
            limit = distance;
        }
    }
    return best;
}

std::string listed(const std::vector<std::string>& words) {
    constexpr std::size_t most = 20; // more than a table has keys; names of a scene may be many
    std::string text;
    std::size_t shown = 0;
    for (const auto& word : words) {
        if (word.empty()) {
            continue; // whose name is itself a problem
        }
        if (shown == most) {
            return text + ", …";
        }
        text += (shown++ == 0 ? "" : ", ") + word;
    }
    return text;
}

} // namespace nappe::scene_file
