#include "io/row_rules.hpp"

#include "core/large_grains.hpp"
#include "core/tile_grid.hpp"
#include "core/walls.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string_view>
#include <utility>

namespace nappe {

namespace {

constexpr double largest_work = 1e60; ///< [J]

template <class List>
bool are_numbers(const List& list) {
    return std::all_of(std::begin(list), std::end(list), [](double a) { return std::isfinite(a); });
}

template <class List>
std::string listed(const List& list) {
    std::string text;
    for (const double a : list) {
        text += fmt::format("{}{}", text.empty() ? "" : ", ", a);
    }
    return "[" + text + "]";
}

using Named = std::pair<const char*, std::span<const double>>;

std::string broken_numbers(std::initializer_list<Named> fields) {
    for (const auto& [name, values] : fields) {
        if (!are_numbers(values)) {
            return fmt::format("its {} must be finite numbers, found {}", name, listed(values));
        }
    }
    return {};
}

/// What rows of samples and of checkpoints have in common.
template <int D, class Row>
std::string broken_in_any(const Row& g, const RowLimits& limits) {
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
    const Vec<D> x(g.x.data());
    if (limits.tile_side > 0 && !TileGrid<D>(Vec<D>::Zero(), limits.tile_side).in_range(x)) {
        return fmt::format("its position must lie in the world, found {}", listed(g.x));
    }
    return {};
}

template <int D>
std::string broken_rule_of(const GrainRow<D>& g, const RowLimits& limits) {
    const auto broken =
        broken_numbers({{"position", g.x}, {"velocity", g.v}, {"spin", g.spin}, {"rotation", g.rotation}});
    return broken.empty() ? broken_in_any<D>(g, limits) : broken;
}

template <int D>
std::string broken_rule_of(const SnapshotGrain<D>& g, const RowLimits& limits) {
    const auto broken = broken_numbers({{"position", g.x},
                                        {"position at the last rebuild", g.x_ref},
                                        {"velocity", g.v},
                                        {"speed of the rim", g.s},
                                        {"rotation", g.rotation},
                                        {"margin", std::span(&g.margin, 1)}});
    if (!broken.empty()) {
        return broken;
    }
    if (!TileGrid<D>(Vec<D>::Zero(), limits.tile_side).in_range(Vec<D>(g.x_ref.data()))) {
        return fmt::format("its position at the last rebuild must lie in the world, found {}", listed(g.x_ref));
    }
    return broken_in_any<D>(g, limits);
}

template <class Row>
std::string broken_in_block(std::span<const Row> grains, GlobalId first, const RowLimits& limits) {
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
std::string broken_walls(const std::vector<SnapshotWall<D>>& walls, const Scene<D>& scene) {
    if (walls.size() != scene.walls.size()) {
        return fmt::format("there must be {} walls, found {}", scene.walls.size(), walls.size());
    }
    for (std::size_t w = 0; w < walls.size(); ++w) {
        const auto& wall = walls[w];
        const auto broken = broken_numbers({{"displacement", wall.offset},
                                            {"displacement at the last rebuild", wall.offset_ref},
                                            {"velocity", wall.v},
                                            {"velocity before", wall.v_old},
                                            {"margin", std::span(&wall.margin, 1)}});
        if (!broken.empty()) {
            return fmt::format("wall {}: {}", scene.walls[w].name, broken);
        }
    }
    return {};
}

template <int D>
std::string broken_clock(SnapshotClock clock, const Scene<D>& scene) {
    std::string broken;
    clock.for_each([&](const char* name, auto value) {
        const auto number = static_cast<double>(value);
        // Counts are at most what doubles count exactly; work is done in either direction.
        const bool signless = std::string_view(name) != "correction_work";
        if (broken.empty() && (!(std::abs(number) <= (signless ? 0x1p53 : largest_work)) || (signless && number < 0))) {
            broken = fmt::format("{} must be a number{}, found {}", name, signless ? " >= 0" : "", value);
        }
    });
    if (broken.empty() && clock.stage >= static_cast<std::int64_t>(scene.stages.size())) {
        return fmt::format("stage must be one of {}, found number {}", scene.stages.size(), clock.stage);
    }
    if (broken.empty() && clock.summed_steps > std::numeric_limits<int>::max()) {
        return fmt::format("summed_steps must be a count, found {}", clock.summed_steps);
    }
    return broken;
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
    limits.tile_side = scene.tiles.side_for(largest_radius(scene));
    limits.largest_radius *= 1 + round_off;
    return limits;
}

template <int D>
std::string broken_rule(std::span<const GrainRow<D>> grains, GlobalId first, const RowLimits& limits) {
    return broken_in_block(grains, first, limits);
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
            return fmt::format("{}: its impulses must be finite numbers, found {} and {}", name, c.r_n, listed(c.r_t));
        }
        before = {c.lo, c.hi};
    }
    return {};
}

template <int D>
std::string broken_rule(const Snapshot<D>& snapshot, const Scene<D>& scene, GlobalId first, std::int64_t n_grains) {
    const auto limits = row_limits(scene);
    const auto count = static_cast<std::int64_t>(snapshot.grains.size());
    for (const auto& broken : {
             broken_clock(snapshot.clock, scene),
             broken_walls(snapshot.walls, scene),
             broken_in_block(std::span(snapshot.grains), first, limits),
             broken_rule<D>(std::span(snapshot.impulses), first, count, n_grains, limits),
         }) {
        if (!broken.empty()) {
            return broken;
        }
    }
    const auto negative = std::find_if(snapshot.owners.begin(), snapshot.owners.end(),
                                       [](const TileOwner& owner) { return owner.rank < 0; });
    return negative == snapshot.owners.end() ? std::string()
                                             : fmt::format("owners of tiles must be ranks, found {}", negative->rank);
}

template RowLimits row_limits<2>(const Scene<2>&);
template std::string broken_rule<2>(std::span<const GrainRow<2>>, GlobalId, const RowLimits&);
template std::string broken_rule<2>(std::span<const ContactRow<2>>, GlobalId, std::int64_t, std::int64_t,
                                    const RowLimits&);
template std::string broken_rule<2>(const Snapshot<2>&, const Scene<2>&, GlobalId, std::int64_t);

} // namespace nappe
