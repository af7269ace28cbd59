// What `nappe partitions` is made of, against counts by hand: the graph of tiles, tiles under a profile, counting by
// tiles beside counting by grains.
#include "commands/partitions.hpp"
#include "commands/partitions_tiles.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace nappe {
namespace {

TileKey key(std::int64_t x, std::int64_t y) {
    return TileGrid<2>::pack({x, y});
}

std::int64_t weight_between(const TileGraph& graph, TileKey a, TileKey b) {
    for (const auto& e : graph.edges) {
        if (graph.keys[static_cast<std::size_t>(e.a)] == a && graph.keys[static_cast<std::size_t>(e.b)] == b) {
            return e.weight;
        }
    }
    return -1;
}

TEST(tile_graph, work_and_links_add_up_whoever_reports_them) {
    const auto graph =
        tile_graph<2>({{key(1, 0), 5}, {key(0, 0), 3}, {key(1, 0), 2}, {key(5, 5), 1}},
                      {{key(1, 0), key(0, 0), 10}, {key(0, 0), key(1, 0), 4}, {key(0, 0), key(9, 9), 7}});
    EXPECT_EQ(graph.keys, (std::vector<TileKey>{key(0, 0), key(1, 0), key(5, 5)}));
    EXPECT_EQ(graph.weight, (std::vector<std::int64_t>{3, 7, 1}));
    ASSERT_EQ(graph.edges.size(), 1u) << "tiles apart are not joined, nor is one that does no work";
    EXPECT_EQ(weight_between(graph, key(0, 0), key(1, 0)), 1 + 14);
}

TEST(tile_graph, neighbours_that_share_nothing_are_joined_still) {
    const auto graph = tile_graph<2>({{key(0, 0), 3}, {key(0, 1), 3}, {key(1, 1), 3}}, {{key(0, 0), key(0, 1), 2}});
    ASSERT_EQ(graph.edges.size(), 3u);
    EXPECT_EQ(weight_between(graph, key(0, 0), key(0, 1)), 3);
    EXPECT_EQ(weight_between(graph, key(0, 0), key(1, 1)), 1);
    EXPECT_EQ(weight_between(graph, key(0, 1), key(1, 1)), 1);
}

TEST(tile_graph, without_any_link_the_smaller_tile_says_what_is_shared) {
    const auto graph = tile_graph<2>({{key(0, 0), 80}, {key(0, 1), 24}}, {});
    EXPECT_EQ(weight_between(graph, key(0, 0), key(0, 1)), 1 + 24 / 8);
}

TEST(fill_profile, tiles_are_filled_by_their_share_of_the_area) {
    // A step: 30 m wide and 10 m high, 10 m of it 25 m high, on tiles of 10 m that start at (-5, 0).
    const std::vector<Vec<2>> step = {{0, 0}, {30, 0}, {30, 10}, {10, 10}, {10, 25}, {0, 25}};
    const auto tiles = fill_profile(step, TileGrid<2>(Vec<2>(-5, 0), 10), 0.01);
    double area = 0;
    for (const auto& tile : tiles) {
        area += 100 * tile.fill;
    }
    EXPECT_NEAR(area, 300 + 150, 1e-9) << "sums of a dozen products";
    EXPECT_EQ(tiles.size(), 4u + 2u + 2u);
    EXPECT_NEAR(tiles[0].fill, 0.5, 1e-12);
    EXPECT_NEAR(tiles[2].fill, 0.25, 1e-12) << "half as wide, half as high";
    EXPECT_NEAR(tiles[3].fill, 1.0, 1e-12);
}

/// A tile of 100 relaxations whose grains are heard of beyond its right side (20), its top (20) and both (1 at the
/// corner).
TileStatistics made_up() {
    TileStatistics mean;
    mean.grains = 50;
    mean.relaxations = 100;
    const auto bit = [](int x, int y) { return std::uint32_t{1} << (3 * (x + 1) + (y + 1)); };
    mean.touched = {{bit(0, 0), 30},
                    {bit(0, 0) | bit(1, 0), 20},
                    {bit(0, 0) | bit(0, 1), 20},
                    {bit(0, 0) | bit(1, 0) | bit(0, 1) | bit(1, 1), 1}};
    return mean;
}

TEST(count_by_tiles, messages_follow_from_who_owns_the_ring) {
    const std::vector<FilledTile> tiles = {{key(0, 0), 1}, {key(0, 1), 1}, {key(1, 0), 0.5}, {key(1, 1), 1}};
    const auto counts = count_partition(made_up(), tiles, {0, 0, 1, 1}, 2);
    ASSERT_EQ(counts.parts.size(), 2u);
    EXPECT_EQ(counts.parts[0].relaxations(), 200);
    EXPECT_EQ(counts.parts[1].relaxations(), 150);
    EXPECT_EQ(counts.parts[1].grains, 75);
    // Only grains at the right side are within reach of the other part; those of part 1 have nobody on their right.
    ASSERT_EQ(counts.messages.size(), 2u);
    for (const auto& m : counts.messages) {
        EXPECT_EQ(m.from, 0);
        EXPECT_EQ(m.to, 1);
        EXPECT_EQ(m.grains, 21) << "each tile's 20, and the one at the corner once although two tiles hold it";
    }
    EXPECT_EQ(counts.messages[0].colour, TileGrid<2>::colour(key(0, 0)));
    EXPECT_EQ(counts.parts[0].interior, (std::array<std::int64_t, 4>{}));
    EXPECT_EQ(std::accumulate(counts.parts[1].interior.begin(), counts.parts[1].interior.end(), std::int64_t{0}), 150);
}

TEST(count_by_tiles, tiles_that_are_not_full_count_by_their_share) {
    const std::vector<FilledTile> tiles = {{key(0, 0), 0.4}, {key(1, 0), 1}};
    const auto counts = count_partition(made_up(), tiles, {0, 1}, 2);
    ASSERT_EQ(counts.messages.size(), 1u);
    EXPECT_EQ(counts.messages[0].grains, 8) << "21 times 0.4, rounded";
    EXPECT_EQ(counts.parts[0].relaxations(), 40);
}

TEST(merge_messages, parts_of_one_message_become_one_in_order) {
    std::vector<MessageCount> messages = {{1, 0, 0, 3}, {0, 2, 1, 5}, {0, 1, 1, 2}, {0, 2, 1, 4}};
    merge_messages(messages);
    ASSERT_EQ(messages.size(), 3u);
    EXPECT_EQ(messages[0].colour, 1);
    EXPECT_EQ(messages[1].grains, 9);
    EXPECT_EQ(messages[2].from, 1);
}

TEST(scaled, lengths_of_profile_and_walls_grow_and_radii_stay) {
    Scene<2> scene;
    scene.sample = Sample<2>{};
    scene.sample->profile = {{0, 0}, {4, 0}, {4, 2}};
    scene.sample->radii.max = 0.5;
    scene.walls.push_back({"floor", 0, {{0, 0}, {4, 1}}, {}});
    const auto larger = scaled(scene, 2.5);
    EXPECT_EQ(larger.sample->profile[2], Vec<2>(10, 5));
    EXPECT_EQ(larger.walls[0].points[1], Vec<2>(10, 2.5));
    EXPECT_EQ(larger.sample->radii.max, 0.5);
}

} // namespace
} // namespace nappe
