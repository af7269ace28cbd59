#include "io/frame_reader.hpp"

#include "io/hdf5_reader.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <regex>
#include <span>

namespace nappe {

namespace {

/// Not what a frame is: the rule and what was found.
struct NotAFrame : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// HDF5 1.10.8 can crash on what only looks like its file: a signature, and no less than its smallest superblock.
void check_signature(const std::filesystem::path& path) {
    constexpr std::array<char, 8> signature{'\x89', 'H', 'D', 'F', '\r', '\n', '\x1a', '\n'};
    std::ifstream file(path, std::ios::binary);
    std::array<char, 96> head{};
    if (!file || !file.read(head.data(), head.size()) ||
        !std::equal(signature.begin(), signature.end(), head.begin())) {
        throw NotAFrame("must be an HDF5 file that can be read, found something else or nothing");
    }
}

/// Rows [first, first + count) of the datasets of one file; visits components row by row.
class Rows {
public:
    Rows(const Hdf5Reader& file, std::int64_t first, std::int64_t count) : file_(file), first_(first), count_(count) {}

    /// set(row, pointer to the row's elements), for a dataset with that many columns.
    template <class T, class Row, class Set>
    void fill(const std::string& dataset, int columns, std::vector<Row>& rows, Set set) const {
        const auto values = file_.read<T>(dataset, first_, count_, columns);
        const T* from = values.data();
        for (Row& row : rows) {
            set(row, from);
            from += columns;
        }
    }

    template <class T, class Row, class Set>
    void fill(const std::string& dataset, std::vector<Row>& rows, Set set) const {
        fill<T>(dataset, 1, rows, [&](Row& row, const T* from) { set(row, *from); });
    }

private:
    const Hdf5Reader& file_;
    std::int64_t first_, count_;
};

template <int D>
std::vector<FrameGrain<D>> read_grains(const Hdf5Reader& file, std::int64_t first, std::int64_t count) {
    using Row = FrameGrain<D>;
    const std::string data = "/VTKHDF/PointData/";
    std::vector<Row> grains(static_cast<std::size_t>(count));
    const Rows rows(file, first, count);
    rows.fill<double>("/VTKHDF/Points", 3, grains,
                      [](Row& g, const double* x) { std::copy_n(x, D, g.grain.x.data()); });
    rows.fill<double>(data + "velocity", 3, grains,
                      [](Row& g, const double* v) { std::copy_n(v, D, g.grain.v.data()); });
    rows.fill<double>(data + "spin", n_spin<D>, grains,
                      [](Row& g, const double* s) { std::copy_n(s, n_spin<D>, g.grain.spin.data()); });
    rows.fill<double>(data + "rotation", n_spin<D>, grains,
                      [](Row& g, const double* s) { std::copy_n(s, n_spin<D>, g.grain.rotation.data()); });
    rows.fill<std::int64_t>(data + "id", grains, [](Row& g, std::int64_t id) { g.grain.id = id; });
    rows.fill<double>(data + "radius", grains, [](Row& g, double radius) { g.grain.radius = radius; });
    rows.fill<double>(data + "mass", grains, [](Row& g, double mass) { g.grain.mass = mass; });
    rows.fill<std::int32_t>(data + "layer", grains, [](Row& g, std::int32_t layer) { g.grain.layer = layer; });
    rows.fill<std::int32_t>(data + "material", grains, [](Row& g, std::int32_t m) { g.grain.material = m; });
    rows.fill<std::int32_t>(data + "coordination", grains, [](Row& g, std::int32_t n) { g.coordination = n; });
    rows.fill<double>(data + "pressure", grains, [](Row& g, double pressure) { g.pressure = pressure; });
    rows.fill<std::int32_t>(data + "rank", grains, [](Row& g, std::int32_t rank) { g.rank = rank; });
    rows.fill<std::uint64_t>(data + "cells", grains, [](Row& g, std::uint64_t cells) { g.grain.cells = cells; });
    return grains;
}

template <int D>
std::vector<FrameContact<D>> read_contacts(const Hdf5Reader& file, std::int64_t first, std::int64_t count) {
    using Row = FrameContact<D>;
    std::vector<Row> contacts(static_cast<std::size_t>(count));
    const Rows rows(file, first, count);
    rows.fill<std::int64_t>("/contacts/lo", contacts, [](Row& c, std::int64_t lo) { c.lo = lo; });
    rows.fill<std::int64_t>("/contacts/hi", contacts, [](Row& c, std::int64_t hi) { c.hi = hi; });
    rows.fill<std::int32_t>("/contacts/wall", contacts, [](Row& c, std::int32_t wall) { c.wall = wall; });
    rows.fill<double>("/contacts/point", 3, contacts,
                      [](Row& c, const double* x) { std::copy_n(x, D, c.point.data()); });
    rows.fill<double>("/contacts/normal", 3, contacts,
                      [](Row& c, const double* n) { std::copy_n(n, D, c.normal.data()); });
    rows.fill<double>("/contacts/gap", contacts, [](Row& c, double gap) { c.gap = gap; });
    rows.fill<double>("/contacts/r_n", contacts, [](Row& c, double r_n) { c.r_n = r_n; });
    rows.fill<double>("/contacts/r_t", D - 1, contacts,
                      [](Row& c, const double* r) { std::copy_n(r, D - 1, c.r_t.data()); });
    rows.fill<std::int32_t>("/contacts/status", contacts, [](Row& c, std::int32_t status) { c.status = status; });
    if (file.has("/contacts/bond")) {
        rows.fill<std::int32_t>("/contacts/bond", contacts, [](Row& c, std::int32_t bond) { c.bond = bond; });
    }
    return contacts;
}

template <int D>
std::vector<FrameWall<D>> read_walls(const Hdf5Reader& file, const std::vector<std::string>& names) {
    const auto links = wall_links(names);
    std::vector<FrameWall<D>> walls;
    for (std::size_t w = 0; w < names.size(); ++w) {
        const auto path = "/walls/" + links[w];
        if (const auto index = file.integer(path, "index"); index != static_cast<std::int64_t>(w)) {
            throw NotAFrame(fmt::format("wall '{}' must be number {} as in the scene, found {}", names[w], w, index));
        }
        const auto n = file.rows(path);
        const auto x = file.read<double>(path, 0, n, 3);
        FrameWall<D> wall{names[w], {}};
        for (std::size_t k = 0; k < static_cast<std::size_t>(n); ++k) {
            Vec<D> point;
            std::copy_n(x.data() + 3 * k, D, point.data());
            wall.points.push_back(point);
        }
        walls.push_back(std::move(wall));
    }
    return walls;
}

bool all_finite(std::span<const double> values) {
    return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

template <int D>
void check_grains(const std::vector<FrameGrain<D>>& rows, GlobalId first) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto& g = rows[i].grain;
        if (const auto id = first + static_cast<GlobalId>(i); g.id != id) {
            throw NotAFrame(fmt::format("row {} must be of grain {}, found {}", id, id, g.id));
        }
        if (!all_finite(g.x) || !all_finite(g.v) || !all_finite(g.spin)) {
            throw NotAFrame(fmt::format("position and velocity of grain {} must be finite", g.id));
        }
        if (!(std::isfinite(g.radius) && g.radius > 0 && std::isfinite(g.mass) && g.mass > 0)) {
            throw NotAFrame(
                fmt::format("radius and mass of grain {} must be > 0, found {} and {}", g.id, g.radius, g.mass));
        }
    }
}

template <int D>
void check_contacts(const std::vector<FrameContact<D>>& rows, std::int64_t n_grains, std::size_t n_walls) {
    for (const auto& c : rows) {
        const bool of_wall = c.hi >= wall_key;
        const bool ids = c.lo >= 0 && c.lo < n_grains && c.lo < c.hi && (of_wall || c.hi < n_grains);
        const bool wall = of_wall ? c.wall >= 0 && static_cast<std::size_t>(c.wall) < n_walls : c.wall == -1;
        if (!ids || !wall) {
            throw NotAFrame(fmt::format("contacts must be between two of {} grains, or with one of {} walls; found "
                                        "({}, {}) of wall {}",
                                        n_grains, n_walls, c.lo, c.hi, c.wall));
        }
        if (!all_finite(c.normal) || !all_finite(c.r_t) || !std::isfinite(c.r_n) || !std::isfinite(c.gap)) {
            throw NotAFrame(fmt::format("normal, gap and impulse of contact ({}, {}) must be finite", c.lo, c.hi));
        }
    }
}

/// This rank's part, contacts cut evenly. Local; throws what is wrong.
template <int D>
FrameBlock<D> read_part(const Communicator& comm, const std::filesystem::path& path, std::int64_t step,
                        const std::vector<std::string>& wall_names) {
    check_signature(path);
    const Hdf5Reader file(path);
    FrameBlock<D> frame;
    frame.step = file.integer("/", "step");
    frame.time = file.number("/", "time");
    frame.scene_title = file.text("/", "title");
    if (frame.step != step || !std::isfinite(frame.time)) {
        throw NotAFrame(
            fmt::format("must be of step {} as its name says, found step {} at {} s", step, frame.step, frame.time));
    }
    frame.blocks = {file.rows("/VTKHDF/Points"), comm.size()};
    const IdBlocks cut{file.rows("/contacts/lo"), comm.size()};
    const int r = comm.rank();
    frame.grains = read_grains<D>(file, frame.blocks.first(r), frame.blocks.count(r));
    frame.contacts = read_contacts<D>(file, cut.first(r), cut.count(r));
    frame.walls = read_walls<D>(file, wall_names);
    frame.with_bonds = file.has("/contacts/bond");
    check_grains(frame.grains, frame.blocks.first(r));
    check_contacts(frame.contacts, frame.blocks.n, wall_names.size());
    return frame;
}

} // namespace

template <int D>
FrameBlock<D> read_frame(const Communicator& comm, const std::filesystem::path& path, std::int64_t step,
                         const std::vector<std::string>& wall_names) {
    FrameBlock<D> frame;
    std::string error;
    try {
        frame = read_part<D>(comm, path, step, wall_names);
    } catch (const std::exception& failure) {
        error = fmt::format("{}: {}; a frame of this run can not be read: run the scene again; to go on with the run "
                            "nevertheless, nappe restart with --set output.measures.during_run=false",
                            path.string(), failure.what());
    }
    comm.throw_together<InputError>(error);
    // Slabs in the order of ranks, sorted in themselves: what arrives is sorted if the file is.
    frame.contacts =
        send_to_blocks(comm, frame.blocks, std::move(frame.contacts), [](const FrameContact<D>& c) { return c.lo; });
    const auto wrong =
        std::adjacent_find(frame.contacts.begin(), frame.contacts.end(), [](const auto& a, const auto& b) {
            return !(std::pair(a.lo, a.hi) < std::pair(b.lo, b.hi));
        });
    comm.throw_together<InputError>(
        wrong == frame.contacts.end()
            ? std::string()
            : fmt::format("{}: contacts must be in the order of (lo, hi), found ({}, {}) out of it; the file was not "
                          "written by nappe, or is damaged: run the scene again",
                          path.string(), wrong->lo, wrong->hi));
    return frame;
}

std::vector<std::int64_t> stored_frames(const Communicator& comm, const std::filesystem::path& folder) {
    const auto index = folder / "run.xdmf";
    std::vector<std::int64_t> steps;
    std::string error;
    if (comm.is_root()) {
        std::ifstream file(index, std::ios::binary);
        const std::string text{std::istreambuf_iterator<char>(file), {}};
        const std::regex name(R"(frames/frame-([0-9]{8,18})\.hdf)");
        for (std::sregex_iterator at(text.begin(), text.end(), name), end; at != end; ++at) {
            steps.push_back(std::stoll((*at)[1]));
        }
        std::sort(steps.begin(), steps.end());
        steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
        if (steps.empty()) {
            error =
                fmt::format("{}: must list the frames of a run, found {}; give the folder that a run wrote, its --out",
                            index.string(), file.is_open() ? "none" : "no such file");
        }
    }
    comm.throw_together<InputError>(error);
    return comm.all_gather(steps); // the root's, the others have none
}

template FrameBlock<2> read_frame(const Communicator&, const std::filesystem::path&, std::int64_t,
                                  const std::vector<std::string>&);

} // namespace nappe
