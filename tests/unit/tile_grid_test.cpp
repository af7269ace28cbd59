// TileGrid: names, borders, colours and distances of tiles.

#include "core/tile_grid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

namespace nappe {
namespace {

using Grid = TileGrid<2>;
using Coordinates = Grid::Coordinates;

TEST(TileGrid, FloorsOnBothSidesOfTheOrigin) {
    const Grid grid({10, -20}, 2);
    const struct {
        Vec<2> x;
        Coordinates tile;
    } cases[] = {
        {{10, -20}, {0, 0}}, // a lower border belongs to the tile
        {{11.9, -18.1}, {0, 0}},
        {{12, -18}, {1, 1}}, // an upper one to the next
        {{std::nextafter(12.0, 0.0), -18}, {0, 1}},
        {{std::nextafter(10.0, 0.0), -20}, {-1, 0}},
        {{9.9, -20.1}, {-1, -1}},
        {{8, -22}, {-1, -1}},
        {{std::nextafter(8.0, 0.0), -22.5}, {-2, -2}},
        {{-2'000'000, 2'000'000}, {-1'000'005, 1'000'010}},
    };
    for (const auto& c : cases) {
        EXPECT_EQ(grid.coordinates(c.x), c.tile) << c.x.transpose();
        EXPECT_EQ(grid.key(c.x), Grid::pack(c.tile)) << c.x.transpose();
    }
    const Grid at_zero({0, 0}, 2);
    EXPECT_EQ(at_zero.coordinates({-1e-300, -0.0}), (Coordinates{-1, 0}));
}

TEST(TileGrid, KeysKeepTheOrderOfCoordinates) {
    std::vector<Coordinates> tiles;
    for (const std::int64_t x : {-1'000'000'000, -2, -1, 0, 1, 5, 1'000'000'000}) {
        for (const std::int64_t y : {-1'000'000'000, -7, -1, 0, 3, 1'000'000'000}) {
            tiles.push_back({x, y});
        }
    }
    ASSERT_TRUE(std::is_sorted(tiles.begin(), tiles.end()));
    for (std::size_t k = 0; k < tiles.size(); ++k) {
        EXPECT_EQ(Grid::unpack(Grid::pack(tiles[k])), tiles[k]);
        if (k > 0) {
            EXPECT_LT(Grid::pack(tiles[k - 1]), Grid::pack(tiles[k]));
        }
    }
}

TEST(TileGrid, RingIsInOrderAndComplete) {
    for (const Coordinates centre : {Coordinates{0, 0}, Coordinates{-1, 0}, Coordinates{-7, 12}, Coordinates{3, -1}}) {
        const auto ring = Grid::ring(Grid::pack(centre));
        ASSERT_EQ(ring.size(), 9u);
        EXPECT_TRUE(std::is_sorted(ring.begin(), ring.end()));
        std::set<Coordinates> tiles;
        for (const TileKey key : ring) {
            const auto c = Grid::unpack(key);
            EXPECT_LE(std::abs(c[0] - centre[0]), 1);
            EXPECT_LE(std::abs(c[1] - centre[1]), 1);
            tiles.insert(c);
        }
        EXPECT_EQ(tiles.size(), 9u);
    }
}

/// Two tiles of one colour have a tile between them, or share nothing: on both sides of 0, where a bad parity would show.
TEST(TileGrid, TilesOfOneColourAreNeverAdjacent) {
    std::set<int> colours;
    for (std::int64_t x = -4; x <= 4; ++x) {
        for (std::int64_t y = -4; y <= 4; ++y) {
            const TileKey key = Grid::pack({x, y});
            const int colour = Grid::colour(key);
            colours.insert(colour);
            EXPECT_GE(colour, 0);
            EXPECT_LT(colour, n_tile_colours<2>);
            for (const TileKey other : Grid::ring(key)) {
                EXPECT_EQ(Grid::colour(other) == colour, other == key) << x << " " << y;
            }
        }
    }
    EXPECT_EQ(colours.size(), 4u);
}

TEST(TileGrid, DistanceToATile) {
    const Grid grid({-1, 5}, 4); // tile (0, 0) is [-1, 3) x [5, 9)
    const TileKey tile = Grid::pack({0, 0});
    EXPECT_EQ(grid.corner(tile), (Vec<2>(-1, 5)));
    EXPECT_EQ(grid.corner(Grid::pack({-2, 3})), (Vec<2>(-9, 17)));
    const struct {
        Vec<2> x;
        double distance;
    } cases[] = {
        {{0, 6}, 0}, {{-1, 5}, 0}, {{3, 9}, 0},  {{-3, 7}, 2}, {{4.5, 7}, 1.5},
        {{1, 4}, 1}, {{1, 12}, 3}, {{6, 13}, 5}, {{-4, 1}, 5},
    };
    for (const auto& c : cases) {
        EXPECT_DOUBLE_EQ(grid.distance(c.x, tile), c.distance) << c.x.transpose();
    }
}

TEST(TileGrid, KnowsWhatItCanNotName) {
    const Grid grid({0, 0}, 8);
    EXPECT_TRUE(grid.in_range({1e6, -1e6}));
    EXPECT_TRUE(grid.in_range({8e9, -8e9}));
    for (const double far :
         {1e11, -1e11, 1e300, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
        EXPECT_FALSE(grid.in_range({far, 0})) << far;
        EXPECT_FALSE(grid.in_range({0, far})) << far;
    }
}

/// In space: the same with one coordinate more.
TEST(TileGrid, InSpaceColoursAndRingAreThreeDimensional) {
    using Grid3 = TileGrid<3>;
    const Grid3 grid({0, 0, 0}, 1);
    const TileKey key = grid.key({-0.5, 2.5, 7.5});
    EXPECT_EQ(Grid3::unpack(key), (Grid3::Coordinates{-1, 2, 7}));
    const auto ring = Grid3::ring(key);
    EXPECT_TRUE(std::is_sorted(ring.begin(), ring.end()));
    std::set<int> colours;
    for (const TileKey other : ring) {
        colours.insert(Grid3::colour(other));
        EXPECT_EQ(Grid3::colour(other) == Grid3::colour(key), other == key);
    }
    EXPECT_EQ(colours.size(), 8u);
}

} // namespace
} // namespace nappe
