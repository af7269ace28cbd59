// Several sweeps over a part of the sample at a time: allowed only where it changes nothing.
#include "solver/tile_order.hpp"

#include "core/neighbours.hpp"
#include "support/serial_run.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>

namespace nappe::test::tile_order_test {
namespace {

/// Tiles of a ragged patch and of a far island; those with x = 3 are shared with other ranks if `shared`.
CandidateSet<2> patch(bool shared) {
    CandidateSet<2> set;
    for (std::int64_t x = -4; x < 9; ++x) {
        for (std::int64_t y = -2; y < 6; ++y) {
            if ((x * 7 + y * 5) % 6 == 0 || (x == 5 && y > 0)) {
                continue; // holes, and a wall with one way round
            }
            Tile tile;
            tile.key = TileGrid<2>::pack({x, y});
            tile.colour = TileGrid<2>::colour(tile.key);
            tile.interface = shared && x == 3;
            set.tiles.push_back(tile);
        }
    }
    for (std::int64_t x = 40; x < 44; ++x) {
        Tile tile;
        tile.key = TileGrid<2>::pack({x, 1});
        tile.colour = TileGrid<2>::colour(tile.key);
        set.tiles.push_back(tile);
    }
    return set;
}

TEST(TileOrder, NeighboursAreOneLayerApartAtMost) {
    for (const bool shared : {false, true}) {
        const auto set = patch(shared);
        TileOrder<2> order;
        order.build(set);
        std::map<TileKey, int> layer;
        std::size_t n = 0;
        for (int d = 0; d <= order.last_layer(); ++d) {
            for (int colour = 0; colour < 4; ++colour) {
                for (const auto t : order.tiles(d, colour)) {
                    const auto& tile = set.tiles[static_cast<std::size_t>(t)];
                    EXPECT_EQ(tile.colour, colour);
                    EXPECT_EQ(tile.interface, d == 0) << "layer 0 is what other ranks wait for, and nothing else";
                    layer[tile.key] = d;
                    ++n;
                }
            }
        }
        EXPECT_EQ(n, set.tiles.size());
        ASSERT_EQ(layer.size(), set.tiles.size()) << "a tile is in two layers or in none";
        for (const auto& [key, d] : layer) {
            for (const TileKey other : TileGrid<2>::ring(key)) {
                if (layer.count(other) != 0) {
                    EXPECT_LE(std::abs(layer[other] - d), 1);
                }
            }
        }
        EXPECT_GT(order.last_layer(), 3) << "the case is too easy";
    }
}

TEST(TileOrder, SweepsTogetherAreAsManyAsTheCacheHolds) {
    EXPECT_EQ(sweeps_in_cache(1e12, 4, 4), 1) << "a layer larger than any cache";
    EXPECT_GT(sweeps_in_cache(1e5, 100, 4), 1) << "1 kB a layer";
    EXPECT_LE(sweeps_in_cache(1e7, 100, 4), sweeps_in_cache(1e6, 100, 4));
}

/// What the solver makes of 17 sweeps, and colour after colour over all tiles: the same bits.
TEST(TileOrder, ManySweepsAtATimeAreOneAfterTheOther) {
    SceneBuilder b(0.4);
    b.box(120, 12, {RadiusLaw::Kind::uniform, 0.42, 0.56});
    b.stage(solver(0.025, 20));
    SerialRun run(b.scene());
    run.steps(3);
    const auto& sim = run.simulation();
    auto candidates = sim.candidates();
    auto state = sim.state();
    for (LocalId i = 0; i < state.n_held(); ++i) {
        state.u_old[i] = state.u[i];
        state.u[i].v[1] -= 0.025 * standard_gravity;
    }
    auto plain = state;
    DiskContacts together(b.scene(), disk_kernels()), one_by_one(b.scene(), disk_kernels());
    together.pack(state, candidates, sim.walls(), 0.025, false);
    one_by_one.pack(plain, candidates, sim.walls(), 0.025, false);

    const Communicator alone(MPI_COMM_SELF);
    Stopwatch watch;
    ContactSolver<2> nsgs(alone, watch);
    nsgs.order_tiles(candidates);
    Halo<2> halo(alone);
    const int n_sweeps = 17;
    const auto report = nsgs.solve(together, halo, state.u, solver(0.025, n_sweeps), n_sweeps, 0);
    EXPECT_EQ(report.sweeps, n_sweeps);
    EXPECT_EQ(report.relaxations, n_sweeps * one_by_one.n_active());
    for (int sweep = 0; sweep < n_sweeps; ++sweep) {
        for (int colour = 0; colour < 4; ++colour) {
            for (std::size_t t = 0; t < candidates.tiles.size(); ++t) {
                if (candidates.tiles[t].colour == colour) {
                    one_by_one.relax(t, no_tile, plain.u);
                }
            }
        }
    }
    EXPECT_GT(candidates.tiles.size(), 20u) << "the case is too easy";
    for (LocalId i = 0; i < state.n_held(); ++i) {
        ASSERT_EQ(state.u[i].v, plain.u[i].v) << i;
        ASSERT_EQ(state.u[i].s, plain.u[i].s) << i;
    }
}

} // namespace
} // namespace nappe::test::tile_order_test
