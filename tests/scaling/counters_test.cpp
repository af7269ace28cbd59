// What limits scaling, counted and not timed: on two ranks, a layer of about 2,500 disks is cut into equal work, and what
// travels is what the geometry of the cut asks for. Counts are the same on a busy machine and on an idle one.
#include "core/deposit.hpp"
#include "solver/simulation.hpp"
#include "support/halo_truth.hpp"

#include <gtest/gtest.h>

#include <set>

namespace nappe {
namespace {

constexpr double length = 252, height = 9, side = 8; // [m]
constexpr double driven = 0.5;                       // [m/s]
constexpr int n_sweeps = 10;

Scene<2> layer() {
    Scene<2> scene;
    scene.gravity = {0, -9.81};
    scene.materials = {{"rock", 2800}, {"wall", 0}};
    scene.laws = {{0, 0, 0.4, 0}, {0, 1, 0.4, 0}};
    Sample<2> sample;
    sample.radii = {RadiusLaw::Kind::uniform, 0.42, 0.56};
    sample.profile = {{0, 0}, {length, 0}, {length, height}, {0, height}};
    scene.sample = sample;
    const auto wall = [](const char* name, std::vector<Vec<2>> points) {
        Wall<2> w;
        w.name = name;
        w.material = 1;
        w.points = std::move(points);
        return w;
    };
    scene.walls = {wall("floor", {{0, 0}, {length, 0}}), wall("piston", {{0, 30}, {0, 0}}),
                   wall("right", {{length, 0}, {length, 30}})};
    scene.walls[1].motion = Motion<2>{{driven, 0}, 0, 0, {}};
    Stage push;
    push.name = "push";
    push.duration = 10;
    push.solver.h = 0.025;
    push.solver.sweeps = n_sweeps;
    scene.stages = {push};
    scene.tiles.side = side;
    scene.balance = {1.01, 20, BalanceSettings::By::work, BalanceSettings::Moves::always}; // no clock in it
    return scene;
}

class Scaling : public testing::Test {
protected:
    Scaling() {
        std::vector<GrainRow<2>> grains;
        if (world.is_root()) {
            grains = deposit(*scene.sample, scene.materials[0].density, scene.gravity);
        }
        simulation.load(grains, {}, scene.stages[0].solver.h);
        simulation.start_stage(0);
        for (int k = 0; k < 100; ++k) { // forces find their paths, and tiles their ranks
            simulation.step();
        }
    }

    std::int64_t n_grains() const { return simulation.domain().n_grains(); }

    const Communicator world;
    const Scene<2> scene = layer();
    Simulation<2> simulation{world, scene, disk_kernels(nullptr)};
};

TEST_F(Scaling, RelaxationsPerRankAreWithinFivePercentOfHalf) {
    ASSERT_EQ(world.size(), 2);
    EXPECT_GT(n_grains(), 2000);
    EXPECT_LT(n_grains(), 3000);
    const auto before = simulation.counters().relaxations;
    for (int k = 0; k < 20; ++k) {
        simulation.step();
    }
    const auto mine = simulation.counters().relaxations - before;
    const double share = static_cast<double>(mine) / static_cast<double>(world.sum(mine));
    if (world.is_root()) {
        std::printf("rank 0 did %.4f of the relaxations\n", share);
    }
    EXPECT_NEAR(share, 0.5, 0.025); // 5 % of half
}

TEST_F(Scaling, TrafficOfASweepIsThatOfTheGrainsAtTheCut) {
    const auto& halo = simulation.domain().halo();
    Counters at_start;
    HaloTraffic predicted, before;
    do { // a step without a rebuild in it and not redone, so that the lists seen here are those it used, once
        at_start = simulation.counters();
        predicted = halo.per_sweep();
        before = halo.traffic();
        simulation.step();
    } while (simulation.counters().rebuilds != at_start.rebuilds ||
             simulation.counters().redone_packs != at_start.redone_packs);
    const test::HaloTruth truth(world, simulation.state(), simulation.candidates());
    const auto counted = truth.traffic_of(world.rank());
    EXPECT_EQ(predicted.messages_sent, counted.messages_sent);
    EXPECT_EQ(predicted.bytes_sent, counted.bytes_sent);
    // The sweeps and, before them, the warm start: it hands round what it changed as a sweep does.
    EXPECT_EQ(halo.traffic().messages_sent - before.messages_sent, (n_sweeps + 1) * counted.messages_sent);
    EXPECT_EQ(halo.traffic().bytes_sent - before.bytes_sent, (n_sweeps + 1) * counted.bytes_sent);

    // One neighbour: at most a message a colour. Grains that both hold lie within reach, two grains wide, of the cut on either
    // side; a cut across is as high as the layer, or one tile longer where it has a step. Each is sent for at most the four
    // tiles, of four colours, that can touch it.
    EXPECT_LE(counted.messages_sent, n_tile_colours<2>);
    const auto both =
        std::count_if(truth.holders.begin(), truth.holders.end(), [](const auto& of) { return of.second.size() == 2; });
    const double reach = 2 * 0.56 + 2 * 0.3 * 0.56; // r_max and half the skin, twice [m]
    const double most = 2 * reach * (height + side + 2 * reach) / (0.42 * 0.42 * 3.14 / 0.9);
    if (world.is_root()) {
        std::printf("%lld messages and %lld bytes a sweep from rank 0; both ranks hold %lld of %lld grains\n",
                    static_cast<long long>(counted.messages_sent), static_cast<long long>(counted.bytes_sent),
                    static_cast<long long>(both), static_cast<long long>(n_grains()));
    }
    EXPECT_LE(static_cast<double>(both), most);
    EXPECT_LE(counted.bytes_sent, n_tile_colours<2> * 24 * both);
}

TEST_F(Scaling, OnlyTilesNextToTheCutAreInterface) {
    const auto& directory = simulation.domain().directory();
    std::int64_t contacts = 0, of_interface = 0, n_interface = 0, next_to_cut = 0;
    for (const auto& tile : simulation.candidates().tiles) {
        const auto ring = TileGrid<2>::ring(tile.key);
        const bool next = std::any_of(ring.begin(), ring.end(), [&](TileKey key) {
            return directory.owner(key) >= 0 && directory.owner(key) != world.rank();
        });
        EXPECT_TRUE(next || !tile.interface) << "a tile away from the cut waits for the other rank";
        const auto n = tile.candidates_end - tile.candidates_begin;
        contacts += n;
        of_interface += tile.interface ? n : 0;
        n_interface += tile.interface ? 1 : 0;
        next_to_cut += next ? 1 : 0;
    }
    const double share = static_cast<double>(world.sum(of_interface)) / static_cast<double>(world.sum(contacts));
    n_interface = world.sum(n_interface);
    next_to_cut = world.sum(next_to_cut);
    if (world.is_root()) {
        std::printf("interface: %lld tiles, %.4f of the contacts\n", static_cast<long long>(n_interface), share);
    }
    EXPECT_GT(n_interface, 1);
    // Two rows of tiles. A cut straight up has two columns beside it, four tiles; with a step in it three columns, six tiles.
    EXPECT_LE(next_to_cut, 6);
    // So three columns of 8 m at most, of 252 m, if contacts were spread evenly; they are to a quarter.
    EXPECT_LT(share, 1.25 * 3 * side / length);
}

} // namespace
} // namespace nappe
