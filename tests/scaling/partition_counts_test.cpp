// What `nappe partitions` counts on one rank is what real ranks send and relax, to the message and the byte: each rank
// sets its own halo beside the counts of the same cut.
#include "core/initial_grains.hpp"
#include "core/neighbours.hpp"
#include "io/scene_reader.hpp"
#include "parallel/partition_counts.hpp"
#include "parallel/tile_graph.hpp"
#include "solver/simulation.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace nappe {
namespace {

class Counts : public testing::Test {
protected:
    Counts() {
        std::vector<GrainRow<2>> grains;
        if (world.is_root()) {
            grains = initial_grains(scene);
        }
        simulation.load(grains, {}, scene.stages[0].solver.h);
        simulation.start_stage(0);
        for (int k = 0; k < 20; ++k) { // tiles change hands, margins differ
            simulation.step();
        }
        simulation.start_stage(0); // lists of where the grains are now
        gather();
    }

    /// Collective. The same grains on every rank, as one rank alone would hold them.
    void gather() {
        std::vector<GrainRecord<2>> mine;
        for (LocalId i = 0; i < simulation.state().n_own; ++i) {
            mine.push_back(simulation.state().record(i));
        }
        auto grains = world.all_gather(mine);
        const auto& grid = simulation.domain().grid();
        const auto tile = [&](const auto& g) { return grid.key(Vec<2>(g.x[0], g.x[1])); };
        std::sort(grains.begin(), grains.end(),
                  [&](const auto& p, const auto& q) { return tile(p) != tile(q) ? tile(p) < tile(q) : p.id < q.id; });
        all.assign(grains, {}, simulation.walls().n_bodies());
        candidates = find_candidates(all, grid, simulation.walls(), ContactMemory<2>{});
        for (const auto& t : candidates.tiles) {
            listed.push_back(t.candidates_end - t.candidates_begin);
        }
    }

    PartitionCounts<2> counted(const TileDirectory& directory) const {
        return count_partition<2>(all, simulation.domain().grid(), candidates, listed, directory, world.size());
    }

    const Communicator world;
    const Scene<2> scene = read_scene(NAPPE_SOURCE_DIR "/tests/support/scenes/small_fold.toml",
                                      {"balance={ threshold = 1.0, every = 1 }"});
    Simulation<2> simulation{world, scene, disk_kernels(nullptr)};
    State<2> all;
    CandidateSet<2> candidates;
    std::vector<std::int64_t> listed; ///< candidates of each tile: they stand in for relaxations
};

TEST_F(Counts, messages_and_bytes_are_those_of_the_halo) {
    const auto counts = counted(simulation.domain().directory());
    HaloTraffic expected;
    std::int64_t of_all = 0;
    for (const auto& m : counts.messages) {
        of_all += 1;
        if (m.from == world.rank()) {
            expected.messages_sent += 1;
            expected.bytes_sent += m.grains * bytes_per_sent_grain<2>;
        }
    }
    const auto real = simulation.domain().halo().per_sweep();
    EXPECT_EQ(real.messages_sent, expected.messages_sent);
    EXPECT_EQ(real.bytes_sent, expected.bytes_sent);
    EXPECT_GT(of_all, world.size()) << "hardly anything is exchanged: this test would prove nothing";
}

TEST_F(Counts, work_of_interface_and_interior_tiles_by_colour_is_that_of_the_rank) {
    PartCounts<2> real;
    for (const auto& tile : simulation.candidates().tiles) {
        auto& by_colour = tile.interface ? real.interface : real.interior;
        by_colour[static_cast<std::size_t>(tile.colour)] += tile.candidates_end - tile.candidates_begin;
        real.tiles += 1;
        real.grains += tile.grains_end - tile.grains_begin;
    }
    const auto counts = counted(simulation.domain().directory());
    const auto& expected = counts.parts[static_cast<std::size_t>(world.rank())];
    EXPECT_EQ(real.interface, expected.interface);
    EXPECT_EQ(real.interior, expected.interior);
    EXPECT_EQ(real.tiles, expected.tiles);
    EXPECT_EQ(real.grains, expected.grains);
}

TEST_F(Counts, links_of_one_rank_and_of_many_make_the_same_graph) {
    const auto& grid = simulation.domain().grid();
    std::vector<TileWork> work;
    for (const auto& tile : simulation.candidates().tiles) {
        work.push_back({tile.key, tile.candidates_end - tile.candidates_begin});
    }
    const auto links = tile_links(simulation.state(), grid, simulation.candidates());
    const auto of_many = tile_graph<2>(world.all_gather(work), world.all_gather(links));
    work.clear();
    for (std::size_t t = 0; t < listed.size(); ++t) {
        work.push_back({candidates.tiles[t].key, listed[t]});
    }
    const auto of_one = tile_graph<2>(work, tile_links(all, grid, candidates));
    EXPECT_EQ(of_many.keys, of_one.keys);
    EXPECT_EQ(of_many.weight, of_one.weight);
    EXPECT_EQ(partition(of_many, world.size()), partition(of_one, world.size()));
}

} // namespace
} // namespace nappe
