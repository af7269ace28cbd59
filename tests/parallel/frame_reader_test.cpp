// Frames come back as they were written, on any number of ranks, and what is no frame is refused on all of them.
#include "io/frame_reader.hpp"

#include "core/error.hpp"
#include "parallel/made_up_frame.hpp"
#include "parallel/shared_folder.hpp"
#include "unit/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <functional>
#include <limits>

namespace nappe {
namespace {

using test::made_up_frame;
using test::SharedFolder;

const std::vector<std::string> walls{"floor", "left/wall"};

template <class T>
bool same_bits(const T& a, const T& b) {
    return std::memcmp(&a, &b, sizeof(T)) == 0;
}

void expect_same(const FrameBlock<2>& found, const FrameBlock<2>& written) {
    EXPECT_EQ(found.step, written.step);
    EXPECT_TRUE(same_bits(found.time, written.time));
    EXPECT_EQ(found.scene_title, written.scene_title);
    EXPECT_EQ(found.blocks.n, written.blocks.n);
    ASSERT_EQ(found.grains.size(), written.grains.size());
    for (std::size_t i = 0; i < found.grains.size(); ++i) {
        const auto &p = found.grains[i], &q = written.grains[i];
        EXPECT_TRUE(p.grain.id == q.grain.id && same_bits(p.grain.x, q.grain.x) && same_bits(p.grain.v, q.grain.v) &&
                    same_bits(p.grain.spin, q.grain.spin) && same_bits(p.grain.rotation, q.grain.rotation) &&
                    same_bits(p.grain.radius, q.grain.radius) && same_bits(p.grain.mass, q.grain.mass) &&
                    p.grain.cells == q.grain.cells && p.grain.material == q.grain.material &&
                    p.grain.layer == q.grain.layer && same_bits(p.pressure, q.pressure) &&
                    p.coordination == q.coordination && p.rank == q.rank)
            << "grain " << q.grain.id;
    }
    ASSERT_EQ(found.contacts.size(), written.contacts.size());
    for (std::size_t i = 0; i < found.contacts.size(); ++i) {
        const auto &p = found.contacts[i], &q = written.contacts[i];
        EXPECT_TRUE(p.lo == q.lo && p.hi == q.hi && same_bits(p.point, q.point) && same_bits(p.normal, q.normal) &&
                    same_bits(p.gap, q.gap) && same_bits(p.r_n, q.r_n) && same_bits(p.r_t, q.r_t) && p.wall == q.wall &&
                    p.status == q.status)
            << "contact " << q.lo << ", " << q.hi;
    }
    ASSERT_EQ(found.walls.size(), written.walls.size());
    for (std::size_t w = 0; w < found.walls.size(); ++w) {
        EXPECT_EQ(found.walls[w].name, written.walls[w].name);
        EXPECT_EQ(found.walls[w].points, written.walls[w].points);
    }
}

TEST(FrameReader, GivesBackWhatWasWritten) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    const auto path = folder.path() / "frame.hdf";
    for (const GlobalId n : {GlobalId{1}, GlobalId{2}, GlobalId{1001}}) {
        for (const bool with_contacts : {true, false}) {
            const auto written = in_blocks(world, made_up_frame(world, n, with_contacts));
            write_frame(world, path, written);
            expect_same(read_frame<2>(world, path, 250, walls), written);
        }
    }
}

TEST(FrameReader, ReadsWhatOneRankWrote) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    const auto path = folder.path() / "frame.hdf";
    if (world.is_root()) {
        const Communicator alone(MPI_COMM_SELF);
        write_frame(alone, path, made_up_frame(alone, 300, true, false));
    }
    world.barrier();
    expect_same(read_frame<2>(world, path, 250, walls), in_blocks(world, made_up_frame(world, 300, true, false)));
}

/// What all ranks throw, the same text on each, or a failure of the test.
std::string refusal(const Communicator& world, const std::filesystem::path& path, std::int64_t step = 250,
                    const std::vector<std::string>& names = walls) {
    std::string text;
    try {
        read_frame<2>(world, path, step, names);
    } catch (const InputError& error) {
        text = error.what();
    }
    EXPECT_NE(text, "") << "read without an error";
    std::string of_root = text;
    world.broadcast(of_root);
    EXPECT_EQ(text, of_root);
    EXPECT_NE(text.find(path.string()), std::string::npos) << text;
    EXPECT_NE(text.find("run the scene again"), std::string::npos) << text;
    return text;
}

TEST(FrameReader, RefusesFilesThatAreNoFrames) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    const auto path = folder.path() / "frame.hdf";
    refusal(world, folder.path() / "missing.hdf");
    write_frame<2>(world, path, made_up_frame(world, 200));
    const auto whole = test::text_of(path);
    for (const std::size_t length : {std::size_t{0}, std::size_t{50}, std::size_t{2000}, whole.size() - 1}) {
        world.barrier();
        if (world.is_root()) {
            std::ofstream(path, std::ios::binary | std::ios::trunc) << whole.substr(0, length);
        }
        world.barrier();
        refusal(world, path);
    }
    world.barrier();
    if (world.is_root()) {
        std::ofstream(path, std::ios::binary | std::ios::trunc) << std::string(5000, 'x');
    }
    world.barrier();
    EXPECT_NE(refusal(world, path).find("must be an HDF5 file"), std::string::npos);
}

TEST(FrameReader, RefusesFramesOfAnotherRun) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    const auto path = folder.path() / "frame.hdf";
    write_frame<2>(world, path, made_up_frame(world, 20));
    EXPECT_NE(refusal(world, path, 275).find("step 275"), std::string::npos);
    EXPECT_NE(refusal(world, path, 250, {"floor", "piston"}).find("/walls/piston"), std::string::npos);
    EXPECT_NE(refusal(world, path, 250, {"left/wall", "floor"}).find("number 0"), std::string::npos);
}

TEST(FrameReader, RefusesNumbersThatMakeNoSense) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    const auto path = folder.path() / "frame.hdf";
    using Change = std::function<void(FrameGrain<2>&, FrameContact<2>&)>;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<std::pair<const char*, Change>> changes{
        {"must be of grain", [](auto& g, auto&) { g.grain.id += 1; }},
        {"must be finite", [&](auto& g, auto&) { g.grain.x[1] = nan; }},
        {"must be finite", [&](auto& g, auto&) { g.grain.v[0] = -1 / 0.0; }},
        {"must be > 0", [](auto& g, auto&) { g.grain.radius = 0; }},
        {"must be > 0", [&](auto& g, auto&) { g.grain.mass = nan; }},
        {"must be finite", [&](auto&, auto& c) { c.r_n = nan; }},
        {"between two of 40 grains", [](auto&, auto& c) { c.hi = 40; }},
        {"between two of 40 grains", [](auto&, auto& c) { c.hi = c.lo; }},
        {"with one of 2 walls", [](auto&, auto& c) { c.hi = wall_key, c.wall = 2; }},
        {"in the order of (lo, hi)", [](auto&, auto& c) { std::swap((&c)[0], (&c)[1]); }},
    };
    for (const auto& [named, change] : changes) {
        auto frame = in_blocks(world, made_up_frame(world, 40));
        if (world.rank() ==
            world.size() - 1) { // a grain and a contact of the last block, that contact not its grain's last
            auto& contacts = frame.contacts;
            const auto twice = std::adjacent_find(contacts.begin(), contacts.end(),
                                                  [](const auto& a, const auto& b) { return a.lo == b.lo; });
            ASSERT_NE(twice, contacts.end());
            change(frame.grains.front(), *twice);
        }
        write_frame(world, path, frame);
        const auto text = refusal(world, path);
        EXPECT_NE(text.find(named), std::string::npos) << text;
    }
}

TEST(FrameReader, TheIndexSaysWhichFramesBelongToARun) {
    const Communicator world(MPI_COMM_WORLD);
    const SharedFolder folder(world);
    EXPECT_THROW(stored_frames(world, folder.path()), InputError);
    if (world.is_root()) {
        std::ofstream(folder.path() / "run.xdmf")
            << "<DataItem>frames/frame-00000250.hdf:/VTKHDF/Points</DataItem>\n"
            << "frames/frame-00000000.hdf:/a frames/frame-00000250.hdf:/b frames/frame-123456789.hdf:/c";
    }
    world.barrier();
    EXPECT_EQ(stored_frames(world, folder.path()), (std::vector<std::int64_t>{0, 250, 123456789}));
}

} // namespace
} // namespace nappe
