#include "io/row_rules.hpp"

#include "core/walls.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace nappe {

namespace {

template <class List>
bool are_numbers(const List& list) {
    return std::all_of(std::begin(list), std::end(list), [](double a) { return std::isfinite(a); });
}

template <class List>
std::string shown(const List& list) {
    std::string text;
    for (const double a : list) {
        text += fmt::format("{}{}", text.empty() ? "" : ", ", a);
    }
    return "[" + text + "]";
}

template <int D>
std::string broken_rule_of(const GrainRow<D>& g, const RowLimits& limits) {
    for (const auto& [name, values] :
         {std::pair("position", std::span<const double>(g.x)), std::pair("velocity", std::span<const double>(g.v)),
          std::pair("spin", std::span<const double>(g.spin)),
          std::pair("rotation", std::span<const double>(g.rotation))}) {
        if (!are_numbers(values)) {
            return fmt::format("its {} must be finite numbers, found {}", name, shown(values));
        }
    }
    if (!(g.radius > 0 && g.radius >= limits.smallest_radius && g.radius <= limits.largest_radius)) {
        return fmt::format("its radius must lie in [{}, {}] m, found {}", limits.smallest_radius, limits.largest_radius,
                           g.radius);
    }
    if (!(g.mass > 0 && std::isfinite(g.mass))) {
        return fmt::format("its mass must be > 0 kg, found {}", g.mass);
    }
    if (g.material < 0 || g.material >= limits.n_materials) {
        return fmt::format("its material must be one of {}, found number {}", limits.n_materials, g.material);
    }
    return {};
}

} // namespace

template <int D>
RowLimits row_limits(const Scene<D>& scene) {
    RowLimits limits;
    limits.n_materials = static_cast<std::int32_t>(scene.materials.size());
    limits.n_wall_bodies = Walls<D>(scene.walls).n_bodies();
    limits.smallest_radius = std::numeric_limits<double>::max();
    limits.largest_radius = 0;
    const auto include = [&](double radius) {
        limits.smallest_radius = std::min(limits.smallest_radius, radius);
        limits.largest_radius = std::max(limits.largest_radius, radius);
    };
    if (scene.sample) {
        include(scene.sample->radii.min);
        include(scene.sample->radii.max);
    }
    for (const auto& grain : scene.grains) {
        include(grain.radius);
    }
    constexpr double round_off = 1e-12; // radii are drawn between the two
    limits.smallest_radius *= 1 - round_off;
    limits.largest_radius *= 1 + round_off;
    return limits;
}

template <int D>
std::string broken_rule(std::span<const GrainRow<D>> grains, GlobalId first, const RowLimits& limits) {
    GlobalId expected = first;
    for (const auto& g : grains) {
        if (g.id != expected) {
            return fmt::format("grains must be there once each, by id: found {} where {} should be", g.id, expected);
        }
        if (const auto broken = broken_rule_of(g, limits); !broken.empty()) {
            return fmt::format("grain {}: {}", g.id, broken);
        }
        ++expected;
    }
    return {};
}

template <int D>
std::string broken_rule(std::span<const ContactRow<D>> contacts, GlobalId first, std::int64_t count,
                        std::int64_t n_grains, const RowLimits& limits) {
    std::pair<GlobalId, GlobalId> before{-1, -1};
    for (const auto& c : contacts) {
        const auto name = fmt::format("contact ({}, {})", c.lo, c.hi);
        if (c.lo < first || c.lo - first >= count) {
            return fmt::format("{}: its first grain must be one of {} … {}", name, first, first + count - 1);
        }
        const bool of_wall = c.hi >= wall_key && c.hi - wall_key < limits.n_wall_bodies;
        const bool of_grain = c.hi > c.lo && c.hi < n_grains;
        if (!of_wall && !of_grain) {
            return fmt::format("{}: its partner must be a later grain of {}, or one of {} faces of walls", name,
                               n_grains, limits.n_wall_bodies);
        }
        if (!(before < std::pair(c.lo, c.hi))) {
            return fmt::format("{} must come after ({}, {}): they are sorted, each pair once", name, before.first,
                               before.second);
        }
        if (!std::isfinite(c.r_n) || !are_numbers(c.r_t)) {
            return fmt::format("{}: its impulses must be finite numbers, found {} and {}", name, c.r_n, shown(c.r_t));
        }
        before = {c.lo, c.hi};
    }
    return {};
}

template RowLimits row_limits<2>(const Scene<2>&);
template std::string broken_rule<2>(std::span<const GrainRow<2>>, GlobalId, const RowLimits&);
template std::string broken_rule<2>(std::span<const ContactRow<2>>, GlobalId, std::int64_t, std::int64_t,
                                    const RowLimits&);

} // namespace nappe
