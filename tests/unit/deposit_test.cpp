#include "core/deposit.hpp"

#include "core/deposit_packing.hpp"
#include "core/error.hpp"
#include "core/random.hpp"
#include "deposit_checks.hpp"

#include <gtest/gtest.h>

#include <set>

namespace nappe {
namespace {

using namespace deposit_checks;
using Points = std::vector<Vec<2>>;

constexpr double density = 2800;
const Vec<2> down(0, -9.81);

Sample<2> sample_of(Points profile, double r_min = 0.42, double r_max = 0.56) {
    Sample<2> sample;
    sample.radii = {r_min == r_max ? RadiusLaw::Kind::constant : RadiusLaw::Kind::uniform, r_min, r_max};
    sample.profile = std::move(profile);
    return sample;
}

/// The forced fold with all lengths times `scale`, the grains as they are.
Sample<2> fold(double scale) {
    Points profile = {{0, 0}, {1000, 0}, {1000, 30}, {300, 30}, {75, 80}, {0, 80}};
    for (auto& corner : profile) {
        corner *= scale;
    }
    return sample_of(std::move(profile));
}

void expect_sound(const Sample<2>& sample, const std::vector<GrainRow<2>>& rows, const Vec<2>& up = {0, 1}) {
    EXPECT_LE(largest_overlap(sample, rows), 1e-9);
    EXPECT_EQ(unsupported(sample, rows, up), 0);
    for (const auto& row : rows) {
        ASSERT_GE(row.radius, sample.radii.min);
        ASSERT_LE(row.radius, sample.radii.max);
    }
}

TEST(Deposit, FillsTheHalfScaleFoldCompactly) {
    const auto sample = fold(0.5);
    const auto rows = deposit(sample, density, down);
    expect_sound(sample, rows);
    EXPECT_EQ(holes(sample, rows), 0);
    // Required of the full fold, which reaches 0.815; here the surfaces take twice the share.
    EXPECT_GE(solid_fraction(sample, rows), 0.80);
}

// Strictly lowest places first gives 0.2 here; without order between the 5,000 pairs it would be about 0.01.
TEST(Deposit, FloorDoesNotPrintItsRowsOnTheBed) {
    const auto rows = deposit(fold(0.5), density, down);
    EXPECT_LT(order_of_rows(rows, 5), 0.1);
}

TEST(Deposit, RowsCarryWhatTheSampleSays) {
    auto sample = fold(0.25);
    sample.material = 3;
    sample.layer_tops = {2.5, 5, 7.5};
    const auto rows = deposit(sample, density, down);
    std::set<int> layers;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const auto& row = rows[i];
        ASSERT_EQ(row.id, static_cast<GlobalId>(i));
        ASSERT_EQ(row.material, 3);
        ASSERT_DOUBLE_EQ(row.mass, density * M_PI * row.radius * row.radius);
        ASSERT_EQ(row.v, (std::array<double, 2>{}));
        ASSERT_EQ(row.spin[0], 0);
        ASSERT_EQ(row.rotation[0], 0);
        ASSERT_EQ(row.cells, 0U);
        ASSERT_EQ(row.layer, row.x[1] < 2.5 ? 1 : row.x[1] < 5 ? 2 : row.x[1] < 7.5 ? 3 : 4);
        layers.insert(row.layer);
    }
    EXPECT_EQ(layers, (std::set<int>{1, 2, 3, 4}));
    sample.layer_tops.clear();
    EXPECT_EQ(deposit(sample, density, down).back().layer, 1);
}

TEST(Deposit, IsAFunctionOfTheSampleAlone) {
    auto sample = fold(0.25);
    const auto first = deposit(sample, density, down);
    const auto again = deposit(sample, density, down);
    sample.seed = 2;
    const auto other = deposit(sample, density, down);
    ASSERT_EQ(first.size(), again.size());
    bool differs = false;
    for (std::size_t i = 0; i < first.size(); ++i) {
        ASSERT_EQ(first[i].x, again[i].x);
        ASSERT_EQ(first[i].radius, again[i].radius);
        differs = differs || i >= other.size() || first[i].x != other[i].x;
    }
    EXPECT_TRUE(differs);
}

// The radii must be those drawn, in number and law: none preferred because it fits better.
TEST(Deposit, PlacesNearlyAllRadiiDrawn) {
    const auto sample = fold(0.25);
    const auto rows = deposit(sample, density, down);
    std::set<double> drawn;
    for (std::uint64_t k = 0; k < rows.size(); ++k) {
        drawn.insert(0.42 + (0.56 - 0.42) * random_uniform(sample.seed, RandomStream::deposit_radius, k));
    }
    double mean = 0;
    double mean_drawn = 0;
    std::size_t placed = 0;
    double least = 1;
    double most = 0;
    for (const auto& row : rows) {
        placed += drawn.count(row.radius);
        mean += row.radius / static_cast<double>(rows.size());
        least = std::min(least, row.radius);
        most = std::max(most, row.radius);
    }
    for (const double radius : drawn) {
        mean_drawn += radius / static_cast<double>(drawn.size());
    }
    const auto n = static_cast<double>(rows.size());
    // Only the last draws meet a full profile: one in a hundred here.
    EXPECT_GE(static_cast<double>(placed), 0.98 * n);
    // A quarter of the standard error: less than any look at the radii can tell.
    EXPECT_NEAR(mean, mean_drawn, 0.25 * 0.14 / std::sqrt(12 * n));
    // The extreme of n numbers is 1/n of the range from the end on average, and 10/n once in 20,000 samples.
    EXPECT_LT(least, 0.42 + 0.14 * 10 / n);
    EXPECT_GT(most, 0.56 - 0.14 * 10 / n);
}

// Two disks 0.4 apart, a small one sunk between them, another one hanging above: a disk on the first two must be large
// enough to clear the one and small enough to clear the other.
TEST(Packing, ObstaclesForbidSmallerOrLargerRadii) {
    Packing packing({{0, 0}, {20, 0}, {20, 20}, {0, 20}}, 0.1, 2);
    const Site site = {packing.add_disk({4, 1}, 1), packing.add_disk({6.4, 1}, 1)};
    EXPECT_EQ(packing.try_site(site, 0.1).fit, Fit::too_small) << "falls through the gap";
    EXPECT_EQ(packing.try_site(site, 0.3).fit, Fit::fits);
    packing.add_disk({5.2, 1.2}, 0.2);
    packing.add_disk({5.2, 3.2}, 0.3);
    EXPECT_EQ(packing.try_site(site, 0.3).fit, Fit::too_small);
    EXPECT_EQ(packing.try_site(site, 1.0).fit, Fit::too_large);
    const Trial trial = packing.try_site(site, 0.6);
    ASSERT_EQ(trial.fit, Fit::fits);
    EXPECT_NEAR(trial.centre[0], 5.2, 1e-15 * 10);
    EXPECT_NEAR(trial.centre[1], 1 + std::sqrt(1.6 * 1.6 - 1.2 * 1.2), 1e-15 * 10);
}

TEST(Deposit, QuarterTurnOfGravityTurnsEveryDigit) {
    const auto sample = fold(0.1);
    auto turned = sample;
    for (auto& corner : turned.profile) {
        corner = Vec<2>(-corner[1], corner[0]);
    }
    turned.layer_tops = {2};
    const auto rows = deposit(sample, density, down);
    const auto turned_rows = deposit(turned, density, {9.81, 0});
    ASSERT_EQ(rows.size(), turned_rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
        ASSERT_EQ(turned_rows[i].x[0], -rows[i].x[1]);
        ASSERT_EQ(turned_rows[i].x[1], rows[i].x[0]);
        ASSERT_EQ(turned_rows[i].layer, rows[i].x[1] < 2 ? 1 : 2) << "layers are heights against gravity";
    }
}

TEST(Deposit, AnyTurnOfGravityTurnsTheResult) {
    const auto turn = [](const Vec<2>& p) { return Vec<2>(0.8 * p[0] - 0.6 * p[1], 0.6 * p[0] + 0.8 * p[1]); };
    const auto sample = fold(0.1);
    auto turned = sample;
    for (auto& corner : turned.profile) {
        corner = turn(corner);
    }
    const auto rows = deposit(sample, density, down);
    const auto turned_rows = deposit(turned, density, turn(down));
    expect_sound(turned, turned_rows, turn({0, 1}));
    ASSERT_EQ(rows.size(), turned_rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
        // Round-off grows from row to row, some twofold each: 1e-15 × 2^10 at the top.
        ASSERT_LT((centre(turned_rows[i]) - turn(centre(rows[i]))).norm(), 1e-9);
    }
}

TEST(Deposit, OrientationOfTheProfileDoesNotMatter) {
    auto sample = sample_of({{0, 0}, {20, 0}, {20, 8}, {0, 8}});
    std::reverse(sample.profile.begin(), sample.profile.end());
    const auto rows = deposit(sample, density, down);
    expect_sound(sample, rows);
    EXPECT_GT(solid_fraction(sample, rows), 0.7);
}

TEST(Deposit, OneColumnOfEqualGrains) {
    auto sample = sample_of({{0, 0}, {1, 0}, {1, 10}, {0, 10}}, 0.5, 0.5);
    sample.layer_tops = {0.5};
    const auto rows = deposit(sample, density, down);
    expect_sound(sample, rows);
    ASSERT_EQ(rows.size(), 10U);
    EXPECT_EQ(rows.front().layer, 2) << "a centre at a top, here 0.5 exactly, is not below it";
}

TEST(Deposit, OneNarrowColumnZigzags) {
    const auto sample = sample_of({{0, 0}, {1.3, 0}, {1.3, 40}, {0, 40}});
    const auto rows = deposit(sample, density, down);
    expect_sound(sample, rows);
    EXPECT_EQ(holes(sample, rows), 0);
    EXPECT_GE(rows.size(), 40U);
}

TEST(Deposit, ExactlyOneGrain) {
    for (const double width : {1.0, 1.05, 1.5}) {
        const auto sample = sample_of({{0, 0}, {width, 0}, {width, width}, {0, width}}, 0.5, 0.5);
        const auto rows = deposit(sample, density, down);
        ASSERT_EQ(rows.size(), 1U) << width;
        expect_sound(sample, rows);
    }
}

// Shapes a profile may have, all but the first not convex: each must be filled wholly, from every hollow it has.
TEST(Deposit, FillsShapesOfAllKinds) {
    const struct {
        const char* name;
        Points profile;
        double least_fraction; // some 0.05 below what is reached: edges take much of a small profile
    } shapes[] = {
        {"slanted floor", {{0, 0}, {30, 8}, {30, 20}, {0, 20}}, 0.70},
        {"funnel", {{0, 20}, {14, 0.3}, {14.5, 0}, {30, 20}}, 0.70},
        {"cut funnel, its floor narrower than a grain", {{-0.2, 0}, {0.2, 0}, {9, 15}, {-8, 14}}, 0.68},
        {"two basins", {{0, 0}, {10, 0}, {13, 7}, {16, 2}, {28, 2}, {28, 14}, {0, 14}}, 0.70},
        {"level plateau between pits", {{0, 0}, {5, 0}, {5, 6}, {15, 6}, {15, 0}, {20, 0}, {20, 14}, {0, 14}}, 0.66},
        {"steps", {{0, 9}, {6, 9}, {6, 6}, {12, 6}, {12, 3}, {18, 3}, {18, 0}, {26, 0}, {26, 15}, {0, 15}}, 0.66},
        {"corners of 180 degrees", {{0, 0}, {3.3, 0}, {3.9, 0}, {12, 0}, {20, 0}, {20, 10}, {0, 10}, {0, 4}}, 0.72},
        {"fine arc", {}, 0.70},
    };
    for (const auto& shape : shapes) {
        SCOPED_TRACE(shape.name);
        auto sample = sample_of(shape.profile);
        if (sample.profile.empty()) {
            for (int i = 0; i <= 200; ++i) {
                const double angle = M_PI * (1 + i / 200.0);
                sample.profile.push_back(Vec<2>(12 * std::cos(angle), 12 * std::sin(angle)));
            }
        }
        for (sample.seed = 1; sample.seed <= 3; ++sample.seed) {
            const auto rows = deposit(sample, density, down);
            expect_sound(sample, rows);
            EXPECT_EQ(holes(sample, rows), 0);
            EXPECT_GE(solid_fraction(sample, rows), shape.least_fraction);
        }
    }
}

// Under a wall that leans inwards the first grain is wedged in the corner; without it there would be none at all.
TEST(Deposit, StartsInACornerUnderALeaningWall) {
    const auto sample = sample_of({{0, 0}, {30, 0}, {25, 12}, {5, 12}});
    const auto rows = deposit(sample, density, down);
    expect_sound(sample, rows);
    EXPECT_GE(solid_fraction(sample, rows), 0.70);
}

TEST(Deposit, MixesSmallGrainsWithLargeOnes) {
    const auto sample = sample_of({{0, 0}, {30, 0}, {30, 15}, {0, 15}}, 0.1, 0.8);
    const auto rows = deposit(sample, density, down);
    expect_sound(sample, rows);
    EXPECT_EQ(holes(sample, rows), 0);
    EXPECT_GE(solid_fraction(sample, rows), 0.78);
}

TEST(Deposit, FarFromTheOriginItIsAsSound) {
    auto sample = fold(0.1);
    for (auto& corner : sample.profile) {
        corner += Vec<2>(20'000, -30'000);
    }
    expect_sound(sample, deposit(sample, density, down));
}

TEST(Deposit, RefusesWhatItCanNotFill) {
    const Points box = {{0, 0}, {10, 0}, {10, 5}, {0, 5}};
    const struct {
        Sample<2> sample;
        double density;
        Vec<2> gravity;
        const char* says;
    } cases[] = {
        {sample_of(box, 0, 0.5), density, down, "found min 0"},
        {sample_of(box, 0.5, 0.4), density, down, "found min 0.5, max 0.4"},
        {sample_of(box), 0, down, "found 0 kg/m³"},
        {sample_of(box), density, {0, 0}, "needs gravity"},
        {sample_of({{0, 0}, {9, 9}, {9, 0}, {0, 9}}), density, down, "cross"},
        {sample_of({{0, 0}, {0.8, 0}, {0.8, 9}, {0, 9}}), density, down, "at least one grain"},
        {sample_of(box, 1e-5, 1e-5), density, down, "at most 1e9"},
    };
    for (const auto& bad : cases) {
        try {
            deposit(bad.sample, bad.density, bad.gravity);
            ADD_FAILURE() << "nothing thrown where \"" << bad.says << "\" was expected";
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(bad.says), std::string::npos) << error.what();
        }
    }
}

} // namespace
} // namespace nappe
