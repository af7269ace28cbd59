#pragma once
// A scene as text, to compare scenes by.

#include "core/scene.hpp"

#include <fmt/format.h>

#include <string>

namespace nappe::test {

inline std::string shown(const Vec<2>& v) {
    return fmt::format("({:a}, {:a})", v[0], v[1]);
}

inline std::string shown(const SolverSettings& s) {
    return fmt::format(
        "method {} h {:a} substeps {} theta {:a} sweeps {} tolerance {:a} max {} every {} {} geometry {} "
        "adaptive {:a} correction {:a} warm {} coupling {} precision {} unsafe {}",
        static_cast<int>(s.method), s.h, s.substeps, s.theta, s.sweeps, s.tolerance.value_or(-1), s.max_sweeps,
        s.check_every, static_cast<int>(s.at_max), s.geometry_every, s.adaptive.value_or(-1), s.position_correction,
        s.warm_start, static_cast<int>(s.coupling), static_cast<int>(s.precision), s.unsafe);
}

/// Every field of a scene but its text, to the last bit.
inline std::string fields(const Scene<2>& scene) {
    std::string text =
        fmt::format("title {} gravity {} origin {}\n", scene.title, shown(scene.gravity), shown(scene.origin));
    for (const auto& m : scene.materials) {
        text += fmt::format("material {} {:a} {:a} {:a} {:a} {:a}\n", m.name, m.density, m.gamma.value_or(-1),
                            m.d_w.value_or(-1), m.damping, m.spin_damping);
    }
    for (const auto& l : scene.laws) {
        text += fmt::format("law {} {} {:a} {:a} {:a} {:a}", l.material_a, l.material_b, l.friction, l.restitution,
                            l.gamma, l.d_w);
        if (l.springs) {
            const auto& [normal, tangential] = *l.springs;
            text += fmt::format(" springs {:a} {:a} {:a} {:a}", normal.k, tangential.k, normal.c.value_or(-1),
                                tangential.c.value_or(-1));
        }
        text += "\n";
    }
    if (scene.sample) {
        const auto& s = *scene.sample;
        text += fmt::format("sample {} {} {} {:a} {:a} {} profile", static_cast<int>(s.arrangement), s.material,
                            static_cast<int>(s.radii.kind), s.radii.min, s.radii.max, s.seed);
        for (const auto& p : s.profile) {
            text += shown(p);
        }
        for (const auto& top : s.layer_tops) {
            text += fmt::format(" top {:a}", top);
        }
        text += "\n";
    }
    for (const auto& g : scene.grains) {
        text += fmt::format("grain {} {:a} {} {} {:a} {} {}\n", g.material, g.radius, shown(g.position),
                            shown(g.velocity), g.spin[0], g.layer, g.drop);
    }
    for (const auto& w : scene.walls) {
        text += fmt::format("wall {} {} ", w.name, w.material);
        for (const auto& p : w.points) {
            text += shown(p);
        }
        if (w.motion) {
            text += fmt::format(" motion {} {} {:a} {:a}", shown(w.motion->velocity), w.motion->stage, w.motion->start,
                                w.motion->stop.value_or(-1));
        }
        text += "\n";
    }
    for (const auto& s : scene.stages) {
        text += fmt::format("stage {} {:a} {}", s.name, s.duration, shown(s.solver));
        if (s.until) {
            text += fmt::format(" until {:a} {:a} {:a} {:a}", s.until->kinetic, s.until->residual, s.until->unbalanced,
                                s.until->at_most);
        }
        text += "\n";
    }
    const auto& o = scene.output;
    text += fmt::format("output {} {} {:a}", o.frames_every, o.series_every, o.front_bin);
    text += fmt::format(" measures {} {:a} {:a} {}", o.measures.during_run, o.measures.spacing, o.measures.range,
                        o.measures.energy);
    if (o.zone) {
        text += fmt::format(" zone {} {} {:a}", o.zone->wall, shown(o.zone->tip), o.zone->tolerance);
    }
    for (const auto& c : o.cells) {
        text += fmt::format(" cell {} {} {:a}", c.name, shown(c.centre), c.radius);
    }
    for (const auto& g : o.gauges) {
        text += fmt::format(" gauge {} {} {:a} {:a} {} {}", g.name, g.wall, g.from, g.to, g.bins, g.every);
    }
    for (const auto& p : o.probes) {
        text += fmt::format(" probe {} {} {}", p.name, p.grain, p.every);
    }
    const auto& w = scene.watch;
    text += fmt::format(" watch {:a} {} {:a} {} {} {} {} {}", w.overlap.limit, static_cast<int>(w.overlap.then),
                        w.energy.limit, static_cast<int>(w.energy.then), w.residual.steps,
                        static_cast<int>(w.residual.then), static_cast<int>(w.failure), w.max_substeps);
    if (w.bounds) {
        text += fmt::format(" bounds {} {} {}", shown(w.bounds->min), shown(w.bounds->max),
                            static_cast<int>(w.bounds->then));
    }
    return text + fmt::format("\ntiles {:a} {:a} {:a} {:a} balance {:a} {} {} {}\n", scene.tiles.side, scene.tiles.skin,
                              scene.tiles.lookahead, scene.tiles.large_above, scene.balance.threshold,
                              scene.balance.every, static_cast<int>(scene.balance.by),
                              static_cast<int>(scene.balance.moves));
}

} // namespace nappe::test
