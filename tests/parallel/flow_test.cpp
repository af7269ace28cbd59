// The flow's measures of made-up frames: what is known of them, and the same bytes on any number of ranks.
#include "commands/flow_measurer.hpp"
#include "core/error.hpp"
#include "io/hdf5_reader.hpp"
#include "parallel/shared_folder.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <iterator>
#include <numbers>

namespace nappe {
namespace {

using test::SharedFolder;

constexpr double radius = 0.2;
constexpr int columns = 200, rows = 40; // 80 m x 14 m of a hexagonal lattice
const double height = std::sqrt(3.0) * radius * (rows - 1);

Vec<2> place(GlobalId id) {
    const auto row = static_cast<double>(id / columns), k = static_cast<double>(id % columns);
    return {2 * radius * (k + (id / columns % 2 == 0 ? 0.0 : 0.5)), std::sqrt(3.0) * radius * row};
}

/// This rank's block of a lattice whose grains have been carried to motion(place).
std::vector<FrameGrain<2>> block_of(const Communicator& comm, const std::function<Vec<2>(const Vec<2>&)>& motion) {
    const IdBlocks blocks{columns * rows, comm.size()};
    std::vector<FrameGrain<2>> block;
    for (GlobalId id = blocks.first(comm.rank()); id < blocks.first(comm.rank() + 1); ++id) {
        FrameGrain<2> row;
        const Vec<2> x = motion(place(id));
        row.grain.id = id;
        row.grain.x = {x[0], x[1]};
        row.grain.radius = radius;
        row.grain.mass = 2800 * std::numbers::pi * radius * radius;
        row.grain.layer = static_cast<int>(1 + id / columns / 10);
        block.push_back(row);
    }
    return block;
}

Scene<2> scene_with_zone() {
    Scene<2> scene;
    scene.title = "a lattice";
    scene.walls.push_back({"hanging", 0, {{0, 0}, {40, 0}}, Motion<2>{.velocity = {0.3, 0.2}, .start = 0, .stop = {}}});
    scene.output.zone = FaultZone<2>{0, {40, 0}, 0.1};
    return scene;
}

std::vector<FrameWall<2>> walls_at(const Vec<2>& offset) {
    return {{"hanging", {Vec<2>(0, 0) + offset, Vec<2>(40, 0) + offset}}};
}

std::string content(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// The last row of a series: name of the column -> value.
double last_value(const std::filesystem::path& path, const std::string& column) {
    std::ifstream file(path);
    std::string header, line, last;
    std::getline(file, header);
    while (std::getline(file, line)) {
        last = line;
    }
    std::stringstream names(header), values(last);
    for (std::string name, value; std::getline(names, name, ',') && std::getline(values, value, ',');) {
        if (name == column) {
            return std::stod(value);
        }
    }
    ADD_FAILURE() << "no column " << column << " in " << path;
    return 0;
}

/// Three frames of a trishear zone that starts at (40, 0); grains go along straight lines.
void measure_zone(const Communicator& comm, const Scene<2>& scene, const std::filesystem::path& folder) {
    FlowMeasurer measurer(comm, scene, folder);
    const Vec<2> v0(0.3, 0.2);
    const Trishear model{{40, 0}, 0.6, 1.5};
    for (const int k : {0, 1, 2}) {
        const double time = 0.5 * k;
        const auto motion = [&](const Vec<2>& x) { return Vec<2>(x + time * trishear_velocity(model, v0, x)); };
        measurer.measure(100 * k, time, block_of(comm, motion), walls_at(time * v0));
    }
    measurer.finish();
}

TEST(Flow, FilesAreTheSameByteForByteAsOnOneRank) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    const auto scene = scene_with_zone();
    measure_zone(world, scene, folder.path() / "together");
    world.barrier();
    if (world.is_root()) {
        measure_zone(Communicator::alone(), scene, folder.path() / "alone");
        for (const char* name : {"surface.csv", "zone.csv", "fields/fields-00000000.hdf", "fields/fields-00000100.hdf",
                                 "fields/fields-00000200.hdf"}) {
            const auto alone = content(folder.path() / "alone" / name);
            EXPECT_GT(alone.size(), 100u) << name;
            EXPECT_TRUE(alone == content(folder.path() / "together" / name)) << name;
        }
    }
    world.barrier();
}

TEST(Flow, AZoneMadeFromTheModelIsFoundAgain) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    measure_zone(world, scene_with_zone(), folder.path());
    world.barrier();
    const auto zone = [&](const char* column) { return last_value(folder.path() / "zone.csv", column); };
    // Smoothed over w = 1.6 m, a tenth of the depth: the model's parameters return within that, the limits of the
    // tolerance lie inside the apex angle.
    const double fault = std::atan2(0.2, 0.3), half = std::atan(0.6);
    EXPECT_NEAR(zone("trishear_half_angle"), half, 0.06);
    EXPECT_NEAR(zone("trishear_x"), 40, 0.8);
    EXPECT_NEAR(zone("trishear_y"), 0, 0.8);
    EXPECT_LT(zone("trishear_residual"), 0.02);
    EXPECT_GT(zone("left_points"), 5);
    EXPECT_GT(zone("left_angle"), fault + half / 2);
    EXPECT_LT(zone("left_angle"), fault + half + 0.06);
    EXPECT_LT(zone("right_angle"), fault - half / 2);
    EXPECT_GT(zone("right_angle"), fault - half - 0.06);
    EXPECT_DOUBLE_EQ(zone("opening"), zone("left_angle") - zone("right_angle"));
    EXPECT_LE(zone("left_angle_twice"), zone("left_angle_half")); // a wider tolerance, a narrower zone
}

TEST(Flow, SimpleShearAddsUpToItsStrain) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    Scene<2> scene;
    FlowMeasurer measurer(world, scene, folder.path());
    const double rate = 0.05;
    for (const int k : {0, 1, 2, 3, 4}) {
        const double time = 2.0 * k;
        measurer.measure(k, time,
                         block_of(world, [&](const Vec<2>& x) { return Vec<2>(x[0] + rate * time * x[1], x[1]); }), {});
    }
    measurer.finish();
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "zone.csv")); // not asked for
    const Hdf5Reader file(folder.path() / "fields/fields-00000004.hdf");
    const auto n_y = file.rows("/VTKHDF/PointData/shear_strain");
    // Nodes at multiples of 0.8 m; those 8 radii and more inside the sheared lattice.
    const auto left = static_cast<std::int64_t>(std::floor(0 / 0.8)) - 1;
    const auto bottom = left;
    const double reach = 2 * radius * (columns - 0.5) + rate * 8 * height;
    const auto n_x = -(static_cast<std::int64_t>(std::floor(-reach / 0.8)) - 1) - left + 1;
    const auto strain = file.read<double>("/VTKHDF/PointData/shear_strain", 0, n_y, static_cast<int>(n_x));
    const auto velocity = file.read<double>("/VTKHDF/PointData/velocity", 0, n_y, static_cast<int>(3 * n_x));
    int n_checked = 0;
    for (std::int64_t j = 0; j < n_y; ++j) {
        for (std::int64_t i = 0; i < n_x; ++i) {
            const double x = static_cast<double>(left + i) * 0.8, y = static_cast<double>(bottom + j) * 0.8;
            const auto k = static_cast<std::size_t>(j * n_x + i);
            if (y > 3.2 && y < height - 3.2 && x > 3.2 + rate * 8 * y && x < 70) {
                // The kernel's discreteness on a lattice (tests/unit/coarse_grain_test.cpp), and grains within w of the
                // edge whose rate the edge makes one-sided: a few per mille.
                ASSERT_NEAR(strain[k], rate * 8, 0.01 * rate * 8);
                ASSERT_NEAR(velocity[3 * k], rate * y, 0.01 * rate * height);
                ++n_checked;
            }
        }
    }
    EXPECT_GT(n_checked, 400);
}

TEST(Flow, VelocitiesAreThoseOfTheMiddleOfTheWay) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    Scene<2> scene;
    FlowMeasurer measurer(world, scene, folder.path());
    for (const int k : {0, 1}) { // in one second every grain goes on by its x: halfway it is at 1.5 of it
        measurer.measure(k, k, block_of(world, [&](const Vec<2>& x) { return Vec<2>((1 + k) * x[0], x[1]); }), {});
    }
    measurer.finish();
    const Hdf5Reader file(folder.path() / "fields/fields-00000001.hdf");
    const auto n_y = file.rows("/VTKHDF/PointData/velocity");
    const auto n_x = -(static_cast<std::int64_t>(std::floor(-2 * (2 * radius * (columns - 0.5)) / 0.8)) - 1) + 2;
    const auto velocity = file.read<double>("/VTKHDF/PointData/velocity", 0, n_y, static_cast<int>(3 * n_x));
    const std::int64_t i = 50, j = n_y / 2; // node (1, 1) is the origin
    const double x = static_cast<double>(i - 1) * 0.8;
    // To the kernel's discreteness, which is larger on a stretched lattice; at the end of the way it would be x / 2.
    EXPECT_NEAR(velocity[static_cast<std::size_t>(3 * (j * n_x + i))], x / 1.5, 0.01 * x);
}

TEST(Flow, LayersAreProfiledOverAllRanks) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    Scene<2> scene;
    FlowMeasurer measurer(world, scene, folder.path());
    measurer.measure(0, 0.0, block_of(world, [](const Vec<2>& x) { return x; }), {});
    measurer.finish();
    const Hdf5Reader file(folder.path() / "fields/fields-00000000.hdf");
    const auto n = file.rows("/profile/x");
    const auto top = file.read<double>("/profile/layer_top", 0, n, 4);
    const auto mean = file.read<double>("/profile/layer_mean", 0, n, 4);
    const auto surface = file.read<double>("/profile/surface");
    const double course = std::sqrt(3.0) * radius;
    for (std::size_t k = 0; k + 1 < static_cast<std::size_t>(n); ++k) { // the last bin is not full
        ASSERT_DOUBLE_EQ(surface[k], height + radius);
        for (std::size_t layer = 0; layer < 4; ++layer) {
            ASSERT_DOUBLE_EQ(top[4 * k + layer], (10 * static_cast<double>(layer) + 9) * course + radius);
            // Ten courses of two grains a bin each, up to which side of a bin's edge a grain falls on by round-off.
            ASSERT_NEAR(mean[4 * k + layer], (10 * static_cast<double>(layer) + 4.5) * course, course);
        }
    }
}

TEST(Flow, AGrainThatHasFlownOffIsReportedOnAllRanks) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    Scene<2> scene;
    FlowMeasurer measurer(world, scene, folder.path());
    const auto far = [](const Vec<2>& x) { return x.norm() == 0 ? Vec<2>(1e9, 1e9) : x; };
    try {
        measurer.measure(0, 0.0, block_of(world, far), {});
        FAIL() << "accepted";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("output.measures.spacing"), std::string::npos);
    }
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "fields/fields-00000000.hdf"));
}

TEST(Flow, FieldsOfAnOlderRunAreTakenAway) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    const auto old = folder.path() / "fields/fields-00000700.hdf";
    if (world.is_root()) {
        std::filesystem::create_directories(old.parent_path());
        std::ofstream(old) << "old";
        std::ofstream(old.parent_path() / "notes.txt") << "mine";
    }
    world.barrier();
    Scene<2> scene;
    FlowMeasurer measurer(world, scene, folder.path());
    measurer.finish();
    world.barrier();
    EXPECT_FALSE(std::filesystem::exists(old));
    EXPECT_TRUE(std::filesystem::exists(old.parent_path() / "notes.txt"));
}

} // namespace
} // namespace nappe
