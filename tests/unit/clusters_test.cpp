// Blocks of bonded grains, counted by hand.

#include "core/measures/clusters.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace nappe {
namespace {

using Bonds = std::vector<BondedPair>;

TEST(Clusters, ChainsRingsAndLonersAreTold) {
    // 0-1-2-3 in a chain given out of order, 4-5-6 in a ring, 7-8 a pair given twice, 9 and 10 alone.
    const auto found = clusters(11, Bonds{{2, 3}, {0, 1}, {1, 2}, {4, 5}, {5, 6}, {4, 6}, {7, 8}, {7, 8}});
    EXPECT_EQ(found.largest, 4);
    EXPECT_EQ(found.detached, 2);
    EXPECT_EQ(found.detached_grains, 5);
    EXPECT_EQ(found.single, 2);
}

TEST(Clusters, ABondThatJoinsTwoBlocksMakesOne) {
    Bonds bonds{{8, 9}, {6, 7}, {4, 5}, {2, 3}, {0, 1}};
    EXPECT_EQ(clusters(10, bonds).detached, 4);
    for (const BondedPair& joined : Bonds{{1, 9}, {3, 7}, {5, 6}, {0, 2}}) {
        bonds.push_back(joined);
    }
    EXPECT_EQ(clusters(10, bonds).largest, 10);
    EXPECT_EQ(clusters(10, bonds).detached, 0);
}

TEST(Clusters, WithoutBondsNothingIsABlock) {
    const auto found = clusters(3, Bonds{});
    EXPECT_EQ(found.largest, 1);
    EXPECT_EQ(found.detached, 0);
    EXPECT_EQ(found.single, 3);
    EXPECT_EQ(clusters(0, Bonds{}).largest, 0);
}

} // namespace
} // namespace nappe
