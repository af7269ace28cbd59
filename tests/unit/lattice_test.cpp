// Lattices of equal disks: as many as fit, in the middle, touching and never overlapping, in the order promised.
#include "core/lattice.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace nappe {
namespace {

using Arrangement = Sample<2>::Arrangement;

Sample<2> sample(Arrangement arrangement, double width, double height, double r, Vec<2> corner = {0, 0}) {
    Sample<2> s;
    s.arrangement = arrangement;
    s.radii = {RadiusLaw::Kind::constant, r, r};
    s.material = 3;
    const Vec<2> x(width, 0), y(0, height);
    s.profile = {corner, corner + x, corner + x + y, corner + y};
    return s;
}

double gap(const GrainRow<2>& a, const GrainRow<2>& b) {
    return std::hypot(a.x[0] - b.x[0], a.x[1] - b.x[1]) - a.radius - b.radius;
}

/// Pairs that touch; none overlaps. An ulp of a coordinate is what a sum of them may be off by.
std::int64_t touching(const std::vector<GrainRow<2>>& grains, double span) {
    std::int64_t n = 0;
    for (std::size_t i = 0; i < grains.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            EXPECT_GT(gap(grains[i], grains[j]), -4e-16 * span) << i << " " << j;
            n += gap(grains[i], grains[j]) < 4e-16 * span ? 1 : 0;
        }
    }
    return n;
}

TEST(Lattice, SquareHasWholeColumnsInTheMiddle) {
    const double r = 0.25;
    const auto grains = lattice(sample(Arrangement::square, 3.3, 2.2, r, {10, -5}), 2000);
    constexpr int columns = 6, rows = 4; // floor(3.3 / 0.5), floor(2.2 / 0.5)
    ASSERT_EQ(grains.size(), columns * rows);
    EXPECT_EQ(touching(grains, 13.3), (columns - 1) * rows + columns * (rows - 1));
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < columns; ++i) {
            const auto& g = grains[static_cast<std::size_t>(columns * j + i)];
            EXPECT_EQ(g.id, columns * j + i);
            EXPECT_NEAR(g.x[0], 10 + 0.15 + r * (2 * i + 1), 1e-14) << "0.3 m are left, half of it at either side";
            EXPECT_NEAR(g.x[1], -5 + r * (2 * j + 1), 1e-14);
            EXPECT_DOUBLE_EQ(g.mass, 2000 * std::numbers::pi * r * r);
            EXPECT_EQ(g.material, 3);
        }
    }
}

TEST(Lattice, StaggeredRowsLieInTheHollowsOfThoseBelow) {
    const double r = 0.25;
    const auto grains = lattice(sample(Arrangement::staggered, 3.3, 2.2, r), 2000);
    // 1 + floor((2.2 - 0.5) / (sqrt(3) 0.25)) = 4 rows of 6, 5, 6, 5.
    ASSERT_EQ(grains.size(), 22u);
    EXPECT_EQ(touching(grains, 3.3), 5 + 4 + 5 + 4 + 3 * 10) << "each of a short row touches two below and two above";
    EXPECT_NEAR(grains[6].x[0], 0.15 + 2 * r, 1e-14);
    EXPECT_NEAR(grains[6].x[1], r + std::sqrt(3.0) * r, 1e-14);
    EXPECT_NEAR(grains[11].x[0], grains[0].x[0], 1e-14);
    for (std::size_t k = 1; k < grains.size(); ++k) {
        const auto &a = grains[k - 1], &b = grains[k];
        EXPECT_TRUE(b.x[1] > a.x[1] || (b.x[1] == a.x[1] && b.x[0] > a.x[0])) << k;
    }
}

TEST(Lattice, WholeDisksFillAWidthThatDecimalsRound) {
    // 3 m of 3 cm disks: 3 / 0.03 is 100 but for its last bit.
    EXPECT_EQ(lattice(sample(Arrangement::square, 3, 0.5, 0.015), 1800).size(), 100u * 16);
    const auto staggered = lattice(sample(Arrangement::staggered, 3, 1, 0.015), 1800); // 38 rows
    EXPECT_EQ(staggered.size(), 19u * 100 + 19 * 99);
    EXPECT_LT(0.3 / 0.1, 3) << "as numbers go";
    EXPECT_EQ(lattice(sample(Arrangement::square, 0.3, 0.3, 0.05), 1800).size(), 9u);
    EXPECT_EQ(lattice(sample(Arrangement::square, 0.9, 0.9, 0.5), 1).size(), 0u);
}

TEST(Lattice, SizeIsKnownBeforeItIsMade) {
    for (const auto arrangement : {Arrangement::square, Arrangement::staggered}) {
        for (const double height : {0.4, 0.5, 0.9, 1.0, 1.4, 2.2}) { // none, one row, then odd and even numbers of rows
            const auto s = sample(arrangement, 3.3, height, 0.25);
            EXPECT_EQ(lattice_size(s), static_cast<std::int64_t>(lattice(s, 1).size())) << height;
        }
    }
}

TEST(Lattice, LayersGoByCentres) {
    auto s = sample(Arrangement::square, 2, 4, 0.5);
    s.layer_tops = {1, 2.6};
    const auto grains = lattice(s, 1);
    for (const auto& g : grains) {
        EXPECT_EQ(g.layer, g.x[1] < 1 ? 1 : g.x[1] < 2.6 ? 2 : 3) << g.x[1];
    }
}

TEST(Lattice, SaysWhatItCanNotFill) {
    auto s = sample(Arrangement::square, 3, 2, 0.1);
    EXPECT_EQ(lattice_fault(s).key, "");
    std::swap(s.profile[1], s.profile[3]); // the other way round
    EXPECT_EQ(lattice_fault(s).key, "");
    s.profile[2][1] += 0.1;
    EXPECT_EQ(lattice_fault(s).key, "profile");
    s.profile = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {0, 1}};
    EXPECT_EQ(lattice_fault(s).key, "profile");
    s = sample(Arrangement::staggered, 3, 2, 0.1);
    s.radii.max = 0.2;
    EXPECT_EQ(lattice_fault(s).key, "radius");
}

} // namespace
} // namespace nappe
