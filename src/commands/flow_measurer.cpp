#include "commands/flow_measurer.hpp"

#include "core/error.hpp"
#include "core/exact_sum.hpp"
#include "core/no_value.hpp"
#include "io/hdf5_writer.hpp"
#include "io/summary.hpp"

#include <fmt/format.h>

#include <array>
#include <numbers>

namespace nappe {

namespace {

FlowGrain as_flow_grain(const FrameGrain<2>& row, double strain) {
    const auto& g = row.grain;
    return {g.id, g.x, g.v, g.mass, std::numbers::pi * g.radius * g.radius, strain};
}

/// A dataset of doubles by rows.
Hdf5Dataset numbers_dataset(std::string path, const RowRange& rows, int columns, std::span<const double> values,
                            int image_width = 0) {
    const auto bytes = std::as_bytes(values);
    return {std::move(path), ElementType::float64, columns, rows, {bytes.begin(), bytes.end()}, image_width};
}

/// Of one figure of the nodes: get(node, double* components).
template <class Get>
Hdf5Dataset image(const std::string& name, const FieldSlab& fields, int components, Get get) {
    const auto n_x = static_cast<int>(fields.grid.n_x);
    std::vector<double> values(fields.nodes.size() * static_cast<std::size_t>(components));
    for (std::size_t k = 0; k < fields.nodes.size(); ++k) {
        get(k, values.data() + k * static_cast<std::size_t>(components));
    }
    const auto n = values.size();
    values.resize(image_layers * n);
    for (std::size_t layer = 1; layer < image_layers; ++layer) {
        std::copy_n(values.begin(), n, values.begin() + static_cast<std::ptrdiff_t>(layer * n));
    }
    const RowRange rows{fields.rows.first, fields.rows.count, fields.grid.n_y};
    return numbers_dataset("/VTKHDF/PointData/" + name, rows, components * n_x, values, n_x);
}

/// The slab lies behind the plane of the grains, its front on it.
void add_image(const FieldSlab& fields, const Vec<2>& origin, Hdf5Content& content) {
    const auto& nodes = fields.nodes;
    auto& sets = content.datasets;
    sets.push_back(image("solid_fraction", fields, 1, [&](auto k, double* to) { *to = nodes[k].solid_fraction; }));
    sets.push_back(image("velocity", fields, 3, [&](auto k, double* to) {
        std::copy(nodes[k].v.begin(), nodes[k].v.end(), to);
        to[2] = std::isnan(to[0]) ? no_value : 0.0;
    }));
    sets.push_back(image("gradient", fields, 4, [&](auto k, double* to) {
        std::copy(nodes[k].gradient.begin(), nodes[k].gradient.end(), to);
    }));
    sets.push_back(image("shear_rate", fields, 1, [&](auto k, double* to) { *to = nodes[k].shear_rate; }));
    sets.push_back(image("shear_strain", fields, 1, [&](auto k, double* to) { *to = fields.strain[k]; }));

    const auto& grid = fields.grid;
    auto& attributes = content.attributes;
    attributes.push_back({"/VTKHDF", "Version", std::vector<std::int64_t>{1, 0}});
    attributes.push_back({"/VTKHDF", "Type", std::string("ImageData")});
    attributes.push_back(
        {"/VTKHDF", "WholeExtent", std::vector<std::int64_t>{0, grid.n_x - 1, 0, grid.n_y - 1, 0, image_layers - 1}});
    attributes.push_back(
        {"/VTKHDF", "Origin", std::vector<double>{grid.x(0) + origin[0], grid.y(0) + origin[1], -grid.spacing}});
    attributes.push_back({"/VTKHDF", "Spacing", std::vector<double>(3, grid.spacing)});
    attributes.push_back({"/VTKHDF", "Direction", std::vector<double>{1, 0, 0, 0, 1, 0, 0, 0, 1}});
}

void add_profiles(const ProfileSlab& slab, int n_layers, const Vec<2>& origin, Hdf5Content& content) {
    std::vector<double> x(static_cast<std::size_t>(slab.bins.rows));
    for (std::size_t k = 0; k < x.size(); ++k) {
        x[k] = slab.surface.middle(static_cast<std::size_t>(slab.bins.first) + k) + origin[0];
    }
    const auto heights = [&](std::vector<double> y) {
        for (double& value : y) {
            value += origin[1];
        }
        return y;
    };
    auto& sets = content.datasets;
    sets.push_back(numbers_dataset("/profile/x", slab.bins, 1, x));
    sets.push_back(numbers_dataset("/profile/surface", slab.bins, 1, heights(slab.profiles.surface)));
    sets.push_back(numbers_dataset("/profile/layer_top", slab.bins, n_layers, heights(slab.profiles.top)));
    sets.push_back(numbers_dataset("/profile/layer_mean", slab.bins, n_layers, heights(slab.profiles.mean)));
}

/// Makes the folder of fields, empty of what an older run left there; what went wrong, or nothing.
std::string make_folder(const std::filesystem::path& fields) {
    std::error_code error;
    std::filesystem::create_directories(fields, error);
    for (std::filesystem::directory_iterator entry(fields, error), end; !error && entry != end;
         entry.increment(error)) {
        const auto name = entry->path().filename().string();
        if (name.starts_with("fields-") && name.ends_with(".hdf")) {
            std::filesystem::remove(entry->path(), error);
        }
    }
    return error
               ? fmt::format("{}: must be a folder that can be written, found: {}; check the path and its permissions",
                             fields.string(), error.message())
               : std::string();
}

} // namespace

FlowMeasurer::FlowMeasurer(const Communicator& comm, const Scene<2>& scene, std::filesystem::path folder)
    : comm_(comm), scene_(scene), folder_(std::move(folder)) {
    comm_.throw_together<SystemError>(comm_.is_root() ? make_folder(folder_ / "fields") : std::string());
    if (comm_.is_root()) {
        const auto series = [&](const char* name, const std::vector<std::string>& columns) {
            return std::make_unique<SeriesWriter>(folder_ / name, columns);
        };
        surface_series_ = series("surface.csv", {"front", "crest", "slope", "slope_residual", "curvature"});
        if (scene_.output.zone) {
            zone_series_ = series("zone.csv",
                                  {"left_x", "left_angle", "left_residual", "left_points", "right_x", "right_angle",
                                   "right_residual", "right_points", "opening", "trishear_x", "trishear_y",
                                   "trishear_half_angle", "trishear_s", "trishear_residual", "trishear_residual_inside",
                                   "left_angle_half", "right_angle_half", "left_angle_twice", "right_angle_twice"});
        }
    }
    share_errors();
}

void FlowMeasurer::begin(std::span<const FrameGrain<2>> block, const std::vector<FrameWall<2>>& walls) {
    ExactSum radii;
    std::int64_t layers = 1;
    for (const auto& row : block) {
        radii.add(row.grain.radius);
        layers = std::max<std::int64_t>(layers, row.grain.layer);
        grains_.push_back(as_flow_grain(row, 0.0));
    }
    comm_.sum(radii.limbs());
    const auto n = comm_.sum(static_cast<std::int64_t>(block.size()));
    const double mean_radius = radii.value() / static_cast<double>(n);
    const auto& output = scene_.output;
    scales_ = {output.measures.spacing_for(mean_radius), output.measures.range_for(mean_radius)};
    bin_ = output.bin_for(mean_radius);
    rise_ = 4 * mean_radius;
    n_layers_ = static_cast<int>(comm_.max(layers));
    walls_ = walls;
    const auto surface = profiles_of(comm_, bin_, n_layers_, block).surface;
    bed_ = output.zone ? median_height(surface, output.zone->tip[0]) : median_height(surface);
}

void FlowMeasurer::measure(std::int64_t step, double time, std::span<const FrameGrain<2>> block,
                           const std::vector<FrameWall<2>>& walls) {
    const bool first = !begun_;
    if (first) {
        begin(block, walls);
        begun_ = true;
    }
    const double seconds = first ? 0.0 : time - time_;
    std::vector<FlowGrain> moving, present;
    moving.reserve(block.size());
    present.reserve(block.size());
    for (std::size_t k = 0; k < block.size(); ++k) {
        present.push_back(as_flow_grain(block[k], grains_[k].strain));
        moving.push_back(present.back());
        for (std::size_t d = 0; d < 2 && seconds > 0; ++d) {
            moving[k].v[d] = (present[k].x[d] - grains_[k].x[d]) / seconds;
            moving[k].x[d] = (present[k].x[d] + grains_[k].x[d]) / 2;
        }
    }
    const auto fields = coarse_fields(comm_, scales_, moving, seconds, present);
    const auto profiles = profiles_of(comm_, bin_, n_layers_, block);
    write_fields(step, time, fields, profiles);
    const auto shape = shape_of(profiles.surface, bed_, rise_);
    const auto zone =
        scene_.output.zone ? zone_row(fields, profiles.surface, drive(seconds, walls)) : std::vector<double>();
    if (comm_.is_root()) {
        surface_series_->append(step, time,
                                std::array{shape.front + scene_.origin[0], shape.crest + scene_.origin[0], shape.slope,
                                           shape.residual, shape.curvature});
        if (zone_series_) {
            zone_series_->append(step, time, zone);
        }
    }
    share_errors();
    time_ = time;
    grains_ = std::move(present);
    walls_ = walls;
}

/// Of the wall that pushes, as the grains' velocities: what it moved since the frame before over the time.
Vec<2> FlowMeasurer::drive(double seconds, const std::vector<FrameWall<2>>& walls) const {
    const auto wall = static_cast<std::size_t>(scene_.output.zone->wall);
    return seconds > 0 ? Vec<2>((walls[wall].points[0] - walls_[wall].points[0]) / seconds) : Vec<2>(Vec<2>::Zero());
}

std::vector<double> FlowMeasurer::zone_row(const FieldSlab& fields, const Surface& surface, const Vec<2>& drive) const {
    const auto& zone = *scene_.output.zone;
    ZoneRule rule{drive, zone.tolerance, zone.tip[1], scales_.range};
    std::array<ZoneLine, 3> left, right;
    for (std::size_t k = 0; k < 3; ++k) {
        rule.tolerance = zone.tolerance * std::array{1.0, 0.5, 2.0}[k];
        const auto mine = zone_points(fields.grid, fields.rows, fields.nodes, surface, rule);
        left[k] = zone_line(comm_.all_gather(mine.left), rule, scales_.spacing);
        right[k] = zone_line(comm_.all_gather(mine.right), rule, scales_.spacing);
    }
    const auto fit = trishear(fields, surface, rule);
    const Vec<2>& origin = scene_.origin;
    return {left[0].x + origin[0],
            left[0].angle,
            left[0].residual,
            left[0].points,
            right[0].x + origin[0],
            right[0].angle,
            right[0].residual,
            right[0].points,
            left[0].angle - right[0].angle,
            fit.model.tip[0] + origin[0],
            fit.model.tip[1] + origin[1],
            std::atan(fit.model.m),
            fit.model.s,
            fit.residual,
            fit.residual_inside,
            left[1].angle,
            right[1].angle,
            left[2].angle,
            right[2].angle};
}

TrishearFit FlowMeasurer::trishear(const FieldSlab& fields, const Surface& surface, const ZoneRule& rule) const {
    std::vector<std::vector<VelocityAt>> to(static_cast<std::size_t>(comm_.size()));
    for (std::int64_t j = 0; j < fields.rows.count; ++j) {
        for (std::int64_t i = 0; i < fields.grid.n_x; ++i) {
            const double x = fields.grid.x(i), y = fields.grid.y(fields.rows.first + j);
            const auto& node = fields.nodes[fields.grid.node(i, j)];
            if (is_inside(surface, rule, x, y) && !std::isnan(node.v[0])) {
                to[0].push_back({{x, y}, node.v});
            }
        }
    }
    std::vector<VelocityAt> data;
    for (const auto& part : comm_.exchange(to)) {
        data.insert(data.end(), part.begin(), part.end());
    }
    if (!comm_.is_root()) {
        return {};
    }
    // Within two thicknesses of the ground ahead: the block's own tip leaves the fault's, but not so far.
    const auto& tip = scene_.output.zone->tip;
    return fit_trishear(data, rule.drive, {.tip = tip, .reach = 2 * std::max(bed_ - tip[1], scales_.range)});
}

void FlowMeasurer::write_fields(std::int64_t step, double time, const FieldSlab& fields,
                                const ProfileSlab& profiles) const {
    Hdf5Content content;
    add_image(fields, scene_.origin, content);
    add_profiles(profiles, n_layers_, scene_.origin, content);
    content.attributes.push_back({"/", "step", step});
    content.attributes.push_back({"/", "time", time});
    content.attributes.push_back({"/", "range", scales_.range});
    content.attributes.push_back({"/", "title", scene_.title});
    content.attributes.push_back({"/", "version", std::string(program_version())});
    write_hdf5(comm_, folder_ / fmt::format("fields/fields-{:08}.hdf", step), content);
}

void FlowMeasurer::share_errors() const {
    std::string error;
    for (const auto* series : {surface_series_.get(), zone_series_.get()}) {
        if (series != nullptr && error.empty()) {
            error = series->error();
        }
    }
    comm_.throw_together<SystemError>(error);
}

void FlowMeasurer::finish() {
    for (auto* series : {surface_series_.get(), zone_series_.get()}) {
        if (series != nullptr) {
            series->finish();
        }
    }
    share_errors();
}

} // namespace nappe
