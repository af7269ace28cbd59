// Free surfaces and layer profiles that are known by construction.
#include "core/measures/line_fit.hpp"
#include "core/measures/surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace nappe {
namespace {

constexpr double rise = 2;

Surface surface_of(const std::function<double(double)>& height, int n = 200) {
    auto surface = empty_surface(0.5, -4, -4 + n - 1);
    for (std::size_t k = 0; k < surface.height.size(); ++k) {
        surface.height[k] = height(surface.middle(k));
    }
    return surface;
}

/// Flat at 20 up to x = 10, down at a slope of 1/2 to the bed at 0, x = 50.
double ramp(double x) {
    return x < 10 ? 20 : x < 50 ? 25 - x / 2 : 0;
}

TEST(Surface, KeepsTheHighestPointOfEachBin) {
    auto surface = empty_surface(2.0, -1, 1);
    raise_surface(surface, -0.5, 3);
    raise_surface(surface, -1.9, 5);
    raise_surface(surface, 0.0, 1); // an edge belongs to the bin on its right
    EXPECT_EQ(surface.height[0], 5);
    EXPECT_EQ(surface.height_at(1.99), 1);
    EXPECT_FALSE(std::isfinite(surface.height_at(2.5)));
    EXPECT_FALSE(std::isfinite(surface.height_at(100)));
    EXPECT_EQ(surface.middle(0), -1);
    EXPECT_TRUE(empty_surface(1, 0, most_bins + 1).height.empty());
    EXPECT_TRUE(empty_surface(1, 3, 2).height.empty());
}

TEST(Surface, ARampHasItsFrontCrestAndSlope) {
    const auto shape = shape_of(surface_of(ramp), 0, rise);
    // The ramp stands above 2 up to x = 46 and above 18 up to x = 14: the middles of the last bins below those.
    EXPECT_EQ(shape.front, 45.75);
    EXPECT_EQ(shape.crest, 13.75);
    EXPECT_NEAR(shape.slope, std::atan(0.5), 1e-13); // the points lie on the line, round-off of the fit
    EXPECT_NEAR(shape.residual, 0, 1e-12);
    EXPECT_NEAR(shape.curvature, 0, 1e-13);
}

TEST(Surface, AParabolaHasItsCurvature) {
    const double c = 0.013;
    const auto shape =
        shape_of(surface_of([&](double x) { return x < 40 ? c * (40 - x) * (40 - x) / 2 : 0.0; }), 0, rise);
    EXPECT_NEAR(shape.curvature, c, 1e-13);
    EXPECT_GT(shape.residual, 0.1); // a line does not fit it
}

TEST(Surface, AGrainInTheAirIsNoCrestButCountsAsFront) {
    const auto alone = [](double x) { return x == 30.25 ? 60 : x == 80.25 ? 3 : ramp(x); };
    const auto shape = shape_of(surface_of(alone), 0, rise);
    EXPECT_EQ(shape.front, 80.25); // the rule as stated
    EXPECT_EQ(shape_of(surface_of([](double x) { return x == 5.25 ? 60 : ramp(x); }), 0, rise).crest, 13.75);
}

TEST(Surface, WithoutAFrontThereIsNoShape) {
    const auto shape = shape_of(surface_of([](double) { return 1.0; }), 0, rise);
    EXPECT_TRUE(std::isnan(shape.front) && std::isnan(shape.slope) && std::isnan(shape.curvature));
    EXPECT_TRUE(std::isnan(shape_of(empty_surface(1, 0, -1), 0, rise).front));
}

TEST(Surface, TheBedIsTheMedianOfWhatLiesAhead) {
    const auto surface = surface_of([](double x) { return x < 60 ? 20.0 : x < 80 ? 7.0 : 8.0; });
    EXPECT_EQ(median_height(surface), 20);
    EXPECT_EQ(median_height(surface, 60), 7);
    EXPECT_EQ(median_height(surface, 1000), 0);
}

TEST(Surface, LayersHaveTopsAndMeansWeightedWithAreas) {
    const std::vector<ProfileGrain> grains = {
        {{0.5, 1}, 1, 1}, {{0.9, 4}, 2, 1}, {{0.1, 7}, 0.5, 3}, {{1.5, 3}, 0.5, 3}};
    const auto p = layer_profiles(1.0, 0, 3, 3, grains);
    EXPECT_EQ(p.surface[0], 7.5);
    EXPECT_EQ(p.top[0], 6);
    EXPECT_DOUBLE_EQ(p.mean[0], (1 * 1 + 4 * 4) / 5.0);
    EXPECT_TRUE(std::isnan(p.top[1]) && std::isnan(p.mean[1])); // no grain of layer 2
    EXPECT_EQ(p.top[3 + 2], 3.5);
    EXPECT_EQ(p.mean[3 + 2], 3);
    EXPECT_TRUE(std::isnan(p.surface[2]));
}

TEST(LineFit, IsTheLeastSquaresLine) {
    const std::vector<FitPoint> points = {{0, 1}, {1, 3}, {2, 2}, {3, 6}};
    // By hand: mean (1.5, 3), sum (x - 1.5)(y - 3) = 7, sum (x - 1.5)² = 5.
    const auto line = fit_line(points);
    EXPECT_NEAR(line.slope, 1.4, 1e-14);
    EXPECT_NEAR(line.offset, 0.9, 1e-14);
    EXPECT_NEAR(line.residual, std::sqrt((0.01 + 0.49 + 2.89 + 0.81) / 4), 1e-14); // residuals 0.1, 0.7, -1.7, 0.9
    EXPECT_EQ(line.points, 4u);
    EXPECT_TRUE(std::isnan(fit_line(std::vector<FitPoint>{{0, 1}, {1, 2}}).slope));
    EXPECT_TRUE(std::isnan(fit_line(std::vector<FitPoint>{{1, 1}, {1, 2}, {1, 3}}).slope)); // one place only
}

TEST(LineFit, AnOutlierDoesNotMoveTheRobustOne) {
    std::vector<FitPoint> points;
    for (int k = 0; k < 12; ++k) {
        points.push_back({0.5 * k, 3 - 0.8 * 0.5 * k + (k % 2 == 0 ? 0.05 : -0.05)});
    }
    const auto clean = fit_line(points);
    points.push_back({7, 25});
    const auto robust = fit_line_robustly(points, 0.01);
    EXPECT_EQ(robust.points, 12u);
    EXPECT_DOUBLE_EQ(robust.slope, clean.slope);
    EXPECT_GT(std::abs(fit_line(points).slope - clean.slope), 0.5);
    // Points on one line are all kept, whatever round-off says of their scatter.
    EXPECT_EQ(fit_line_robustly(std::vector<FitPoint>{{0, 0.1}, {1, 0.2}, {2, 0.3}, {3, 0.4}}, 1e-6).points, 4u);
}

} // namespace
} // namespace nappe
