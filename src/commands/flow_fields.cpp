#include "commands/flow_fields.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

#include <array>

namespace nappe {

namespace {

/// 1.5 GB of fields: no picture shows more.
constexpr std::int64_t most_nodes = 16'000'000;

/// The grains that each rank's rows see, sent there; they arrive in the order of ids, since blocks are.
std::vector<FlowGrain> send_to_rows(const Communicator& comm, const FieldGrid& grid, const IdBlocks& rows, double range,
                                    std::span<const FlowGrain> grains) {
    std::vector<std::vector<FlowGrain>> to(static_cast<std::size_t>(comm.size()));
    for (const auto& grain : grains) {
        const auto reach = reached_rows(grid, grain.x[1], range);
        const auto first = std::max<std::int64_t>(reach.first, 0);
        const auto last = std::min(reach.first + reach.count, grid.n_y) - 1;
        for (int r = rows.holder(first); first <= last && r <= rows.holder(last); ++r) {
            to[static_cast<std::size_t>(r)].push_back(grain);
        }
    }
    std::vector<FlowGrain> mine;
    for (const auto& part : comm.exchange(to)) {
        mine.insert(mine.end(), part.begin(), part.end());
    }
    return mine;
}

} // namespace

FieldGrid grid_around(const Communicator& comm, const FieldScales& scales, std::span<const FlowGrain> a,
                      std::span<const FlowGrain> b) {
    constexpr double none = -std::numeric_limits<double>::infinity();
    std::array<double, 4> reach{none, none, none, none}; // largest x, -x, y, -y
    for (const auto grains : {a, b}) {
        for (const auto& grain : grains) {
            for (std::size_t d = 0; d < 2; ++d) {
                reach[2 * d] = std::max(reach[2 * d], grain.x[d]);
                reach[2 * d + 1] = std::max(reach[2 * d + 1], -grain.x[d]);
            }
        }
    }
    comm.max(std::span(reach));
    const double width = reach[0] + reach[1], height = reach[2] + reach[3];
    const double nodes = (width / scales.spacing + 4) * (height / scales.spacing + 4);
    if (!(nodes <= static_cast<double>(most_nodes))) {
        throw InputError(
            fmt::format("output.measures.spacing: the grid of fields must have at most {} nodes, found {:.3g} since "
                        "grains lie within "
                        "{:.6g} x {:.6g} m; give a wider spacing than {:.6g} m, or look for grains that have left",
                        most_nodes, nodes, width, height, scales.spacing));
    }
    FieldGrid grid;
    grid.spacing = scales.spacing;
    const auto below = [&](double x) { return static_cast<std::int64_t>(std::floor(x / scales.spacing)) - 1; };
    grid.first_x = below(-reach[1]);
    grid.first_y = below(-reach[3]);
    grid.n_x = -below(-reach[0]) - grid.first_x + 1;
    grid.n_y = -below(-reach[2]) - grid.first_y + 1;
    return grid;
}

FieldSlab coarse_fields(const Communicator& comm, const FieldScales& scales, std::span<const FlowGrain> moving,
                        double seconds, std::span<FlowGrain> present) {
    FieldSlab slab;
    slab.grid = grid_around(comm, scales, moving, present);
    const IdBlocks rows{slab.grid.n_y, comm.size()};
    slab.rows = {rows.first(comm.rank()), rows.count(comm.rank())};
    CoarseGrain sums(slab.grid, slab.rows, scales.range);
    for (const auto& grain : send_to_rows(comm, slab.grid, rows, scales.range, moving)) {
        sums.add(grain);
    }
    slab.nodes = sums.fields();
    std::vector<double> rate(slab.nodes.size());
    std::transform(slab.nodes.begin(), slab.nodes.end(), rate.begin(),
                   [](const auto& node) { return node.shear_rate; });
    rate = comm.all_gather(rate);
    for (std::size_t k = 0; k < present.size(); ++k) {
        // A grain that no node of the material is near to is in the air, where nothing shears it.
        present[k].strain += between_nodes(slab.grid, rate, moving[k].x).value_or(0.0) * seconds;
    }
    slab.strain =
        coarse_strain(slab.grid, slab.rows, scales.range, send_to_rows(comm, slab.grid, rows, scales.range, present));
    return slab;
}

ProfileSlab profiles_of(const Communicator& comm, double bin, int n_layers, std::span<const FrameGrain<2>> block) {
    constexpr std::int64_t none = std::numeric_limits<std::int64_t>::min();
    std::int64_t last = none, first_negated = none;
    for (const auto& row : block) {
        last = std::max(last, bin_of(row.grain.x[0], bin));
        first_negated = std::max(first_negated, -bin_of(row.grain.x[0], bin));
    }
    last = comm.max(last);
    first_negated = comm.max(first_negated);
    ProfileSlab slab;
    slab.surface = empty_surface(bin, last == none ? 0 : -first_negated, last);
    const IdBlocks bins{static_cast<std::int64_t>(slab.surface.height.size()), comm.size()};
    slab.bins = {bins.first(comm.rank()), bins.count(comm.rank()), bins.n};
    if (bins.n == 0) {
        return slab;
    }
    std::vector<std::vector<ProfileGrain>> to(static_cast<std::size_t>(comm.size()));
    for (const auto& row : block) {
        const auto k = bin_of(row.grain.x[0], bin) - slab.surface.first_bin;
        to[static_cast<std::size_t>(bins.holder(k))].push_back({row.grain.x, row.grain.radius, row.grain.layer});
    }
    std::vector<ProfileGrain> mine;
    for (const auto& part : comm.exchange(to)) {
        mine.insert(mine.end(), part.begin(), part.end());
    }
    slab.profiles = layer_profiles(bin, slab.surface.first_bin + slab.bins.first, slab.bins.rows, n_layers, mine);
    slab.surface.height = comm.all_gather(slab.profiles.surface);
    for (double& height : slab.surface.height) {
        height = std::isnan(height) ? -std::numeric_limits<double>::infinity() : height;
    }
    return slab;
}

} // namespace nappe
