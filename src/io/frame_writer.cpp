#include "io/frame_writer.hpp"

#include "io/hdf5_writer.hpp"
#include "io/summary.hpp"

#include <algorithm>
#include <cstddef>
#include <set>

namespace nappe {

namespace {

constexpr std::uint8_t vtk_vertex = 1;

/// Points and vectors have three components in VTK, whatever D.
template <class Components>
void pad(const Components& from, double* to) {
    for (std::size_t d = 0; d < 3; ++d) {
        to[d] = d < static_cast<std::size_t>(from.size()) ? from[static_cast<decltype(from.size())>(d)] : 0.0;
    }
}

/// Connectivity, offsets and types of n vertices, the parts of an unstructured grid that hold no news.
void add_topology(const Communicator& comm, const RowRange& range, Hdf5Content& content) {
    std::vector<std::int64_t> index(static_cast<std::size_t>(range.rows));
    for (std::size_t i = 0; i < index.size(); ++i) {
        index[i] = range.first + static_cast<std::int64_t>(i);
    }
    const auto same = [](std::int64_t i) { return i; };
    content.add<std::int64_t>("/VTKHDF/Connectivity", range, index, same);
    content.add<std::uint8_t>("/VTKHDF/Types", range, index, [](std::int64_t) { return vtk_vertex; });
    // One offset more than cells: the last rank writes it.
    RowRange offsets{range.first, range.rows, range.total + 1};
    if (comm.rank() == comm.size() - 1) {
        index.push_back(range.total);
        ++offsets.rows;
    }
    content.add<std::int64_t>("/VTKHDF/Offsets", offsets, index, same);
    const std::vector<std::int64_t> total(comm.is_root() ? 1 : 0, range.total);
    for (const char* name : {"NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"}) {
        content.add<std::int64_t>(std::string("/VTKHDF/") + name, by_root(comm, 1), total, same);
    }
}

template <int D>
void add_grains(const RowRange& range, const std::vector<FrameGrain<D>>& grains, Hdf5Content& content) {
    using Row = FrameGrain<D>;
    const std::string point_data = "/VTKHDF/PointData/";
    constexpr int spin_columns = n_spin<D>;
    const auto copy_spin = [](const auto& from, double* to) { std::copy(from.begin(), from.end(), to); };
    content.add<double>("/VTKHDF/Points", 3, range, grains, [](const Row& g, double* to) { pad(g.grain.x, to); });
    content.add<std::int64_t>(point_data + "id", range, grains, [](const Row& g) { return g.grain.id; });
    content.add<double>(point_data + "velocity", 3, range, grains,
                        [](const Row& g, double* to) { pad(g.grain.v, to); });
    content.add<double>(point_data + "spin", spin_columns, range, grains,
                        [&](const Row& g, double* to) { copy_spin(g.grain.spin, to); });
    content.add<double>(point_data + "rotation", spin_columns, range, grains,
                        [&](const Row& g, double* to) { copy_spin(g.grain.rotation, to); });
    content.add<double>(point_data + "radius", range, grains, [](const Row& g) { return g.grain.radius; });
    content.add<double>(point_data + "mass", range, grains, [](const Row& g) { return g.grain.mass; });
    content.add<std::int32_t>(point_data + "layer", range, grains, [](const Row& g) { return g.grain.layer; });
    content.add<std::int32_t>(point_data + "material", range, grains, [](const Row& g) { return g.grain.material; });
    content.add<std::int32_t>(point_data + "coordination", range, grains, [](const Row& g) { return g.coordination; });
    content.add<double>(point_data + "pressure", range, grains, [](const Row& g) { return g.pressure; });
    content.add<std::int32_t>(point_data + "rank", range, grains, [](const Row& g) { return g.rank; });
    content.add<std::uint64_t>(point_data + "cells", range, grains, [](const Row& g) { return g.grain.cells; });
}

template <int D>
void add_contacts(const RowRange& range, const std::vector<FrameContact<D>>& contacts, bool with_bonds,
                  Hdf5Content& content) {
    using Row = FrameContact<D>;
    std::int64_t next = range.first;
    // Its own number, only because readers of XDMF want the vertices of a grid listed.
    content.add<std::int64_t>("/contacts/index", range, contacts, [&](const Row&) { return next++; });
    content.add<std::int64_t>("/contacts/lo", range, contacts, [](const Row& c) { return c.lo; });
    content.add<std::int64_t>("/contacts/hi", range, contacts, [](const Row& c) { return c.hi; });
    content.add<std::int32_t>("/contacts/wall", range, contacts, [](const Row& c) { return c.wall; });
    content.add<double>("/contacts/point", 3, range, contacts, [](const Row& c, double* to) { pad(c.point, to); });
    content.add<double>("/contacts/normal", 3, range, contacts, [](const Row& c, double* to) { pad(c.normal, to); });
    content.add<double>("/contacts/gap", range, contacts, [](const Row& c) { return c.gap; });
    content.add<double>("/contacts/r_n", range, contacts, [](const Row& c) { return c.r_n; });
    content.add<double>("/contacts/r_t", D - 1, range, contacts,
                        [](const Row& c, double* to) { std::copy(c.r_t.begin(), c.r_t.end(), to); });
    content.add<std::int32_t>("/contacts/status", range, contacts, [](const Row& c) { return c.status; });
    if (with_bonds) {
        content.add<std::int32_t>("/contacts/bond", range, contacts, [](const Row& c) { return c.bond; });
    }
}

template <int D>
void add_walls(const Communicator& comm, const std::vector<FrameWall<D>>& walls, Hdf5Content& content) {
    content.groups.push_back("/walls");
    std::vector<std::string> names;
    names.reserve(walls.size());
    for (const auto& wall : walls) {
        names.push_back(wall.name);
    }
    const auto links = wall_links(names);
    for (std::size_t w = 0; w < walls.size(); ++w) {
        const auto& link = links[w];
        const auto range = by_root(comm, walls[w].points.size());
        const auto points = comm.is_root() ? walls[w].points : std::vector<Vec<D>>();
        content.add<double>("/walls/" + link, 3, range, points, [](const Vec<D>& x, double* to) { pad(x, to); });
        content.attributes.push_back({"/walls/" + link, "index", static_cast<std::int64_t>(w)});
    }
}

} // namespace

std::filesystem::path frame_name(std::int64_t step) {
    return fmt::format("frames/frame-{:08}.hdf", step);
}

std::vector<std::string> wall_links(const std::vector<std::string>& names) {
    std::vector<std::string> links;
    std::set<std::string> taken;
    for (std::size_t w = 0; w < names.size(); ++w) {
        std::string link = names[w];
        std::replace(link.begin(), link.end(), '/', '_');
        while (link.empty() || link == "." || taken.contains(link)) {
            link = fmt::format("{}_{}", link, w);
        }
        taken.insert(link);
        links.push_back(link);
    }
    return links;
}

template <int D>
FrameBlock<D> in_blocks(const Communicator& comm, Frame<D>&& frame) {
    FrameBlock<D> block;
    block.step = frame.step;
    block.time = frame.time;
    block.scene_title = std::move(frame.scene_title);
    block.with_bonds = frame.with_bonds;
    block.blocks = {comm.sum(static_cast<std::int64_t>(frame.grains.size())), comm.size()};
    block.grains = grains_in_blocks(comm, block.blocks, std::move(frame.grains),
                                    [](const FrameGrain<D>& g) { return g.grain.id; });
    block.contacts = contacts_in_blocks(comm, block.blocks, std::move(frame.contacts));
    block.walls = std::move(frame.walls);
    return block;
}

template <int D>
void shift(FrameBlock<D>& frame, const Vec<D>& by) {
    if (by.isZero(0)) {
        return; // -0 + 0 is another bit
    }
    const auto move = [&](std::array<double, D>& x) {
        for (std::size_t d = 0; d < D; ++d) {
            x[d] += by[static_cast<Eigen::Index>(d)];
        }
    };
    for (auto& row : frame.grains) {
        move(row.grain.x);
    }
    for (auto& row : frame.contacts) {
        move(row.point);
    }
    for (auto& wall : frame.walls) {
        for (auto& point : wall.points) {
            point += by;
        }
    }
}

template <int D>
FrameCounts write_frame(const Communicator& comm, const std::filesystem::path& path, const FrameBlock<D>& frame) {
    const auto& blocks = frame.blocks;
    const RowRange grain_range{blocks.first(comm.rank()), blocks.count(comm.rank()), blocks.n};
    const RowRange contact_range = row_range(comm, frame.contacts.size());

    Hdf5Content content;
    add_topology(comm, grain_range, content);
    add_grains(grain_range, frame.grains, content);
    add_contacts(contact_range, frame.contacts, frame.with_bonds, content);
    add_walls(comm, frame.walls, content);
    content.attributes.push_back({"/VTKHDF", "Version", std::vector<std::int64_t>{1, 0}});
    content.attributes.push_back({"/VTKHDF", "Type", std::string("UnstructuredGrid")});
    content.attributes.push_back({"/", "step", frame.step});
    content.attributes.push_back({"/", "time", frame.time});
    content.attributes.push_back({"/", "title", frame.scene_title});
    content.attributes.push_back({"/", "version", std::string(program_version())});
    write_hdf5(comm, path, content);
    return {blocks.n, contact_range.total};
}

template <int D>
FrameCounts write_frame(const Communicator& comm, const std::filesystem::path& path, Frame<D>&& frame) {
    return write_frame(comm, path, in_blocks(comm, std::move(frame)));
}

template void shift(FrameBlock<2>&, const Vec<2>&);
template FrameBlock<2> in_blocks(const Communicator&, Frame<2>&&);
template FrameCounts write_frame<2>(const Communicator&, const std::filesystem::path&, const FrameBlock<2>&);
template FrameCounts write_frame<2>(const Communicator&, const std::filesystem::path&, Frame<2>&&);

} // namespace nappe
