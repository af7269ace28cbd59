#include "core/polygon.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace nappe {
namespace {

using Points = std::vector<Vec<2>>;

Points l_shape() {
    return {{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 3}, {0, 3}};
}

TEST(Polygon, AreaHasTheSignOfTheOrientation) {
    Points shape = l_shape();
    EXPECT_DOUBLE_EQ(signed_area(shape), 6);
    EXPECT_DOUBLE_EQ(signed_area(Points(shape.rbegin(), shape.rend())), -6);
}

TEST(Polygon, InsideOfANonConvexShape) {
    const Points shape = l_shape();
    EXPECT_TRUE(is_inside(shape, {0.5, 2}));
    EXPECT_TRUE(is_inside(shape, {3, 0.5}));
    EXPECT_FALSE(is_inside(shape, {2, 2}));
    EXPECT_FALSE(is_inside(shape, {-1, 1})) << "level with a corner";
    EXPECT_TRUE(is_inside(shape, {0.5, 1})) << "level with a corner";
    EXPECT_TRUE(is_inside(Points(shape.rbegin(), shape.rend()), {0.5, 2}));
}

TEST(Polygon, DistancesEndAtCorners) {
    EXPECT_DOUBLE_EQ(distance_to_boundary(l_shape(), {0.25, 2}), 0.25);
    EXPECT_DOUBLE_EQ(distance_to_boundary(l_shape(), {0.4, 0.6}), 0.4);
    EXPECT_DOUBLE_EQ(distance_to_boundary(l_shape(), {0.7, 0.6}), 0.5) << "the corner that points inwards";
    EXPECT_DOUBLE_EQ(distance_to_boundary(l_shape(), {7, -4}), 5);
    EXPECT_EQ(nearest_on_segment({1, 1}, {1, 1}, {5, 5}), Vec<2>(1, 1));
}

TEST(Polygon, DistanceOfSegments) {
    EXPECT_EQ(segment_distance({0, 0}, {2, 2}, {0, 2}, {2, 0}), 0) << "crossing";
    EXPECT_EQ(segment_distance({0, 0}, {2, 0}, {1, 0}, {1, 5}), 0) << "touching";
    EXPECT_EQ(segment_distance({0, 0}, {2, 0}, {1, 0}, {5, 0}), 0) << "overlapping";
    EXPECT_DOUBLE_EQ(segment_distance({0, 0}, {2, 0}, {5, 4}, {9, 9}), 5);
    EXPECT_DOUBLE_EQ(segment_distance({0, 0}, {9, 0}, {1, 2}, {3, 2}), 2) << "parallel";
}

TEST(Polygon, FaultsAreNamedWithTheirValues) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const struct {
        Points points;
        const char* says;
    } cases[] = {
        {{{0, 0}, {1, 0}}, "found 2"},
        {{{0, 0}, {1, nan}, {0, 1}}, "finite"},
        {{{0, 0}, {1, 0}, {1, 0}, {0, 1}}, "found [1, 0] twice"},
        {{{0, 0}, {1, 0}, {0, 1}, {0, 0}}, "found [0, 0] twice"},
        {{{0, 0}, {2, 2}, {2, 0}, {0, 2}}, "cross"},
        {{{0, 0}, {4, 0}, {4, 4}, {2, 0}, {0, 4}}, "touch"},
        {{{0, 0}, {4, 0}, {2, 0}, {2, 3}}, "run back"},
        {{{0, 0}, {4, 0}, {2, 0}}, "run back"},
    };
    for (const auto& bad : cases) {
        EXPECT_NE(polygon_fault(bad.points).find(bad.says), std::string::npos)
            << "expected \"" << bad.says << "\" in \"" << polygon_fault(bad.points) << '"';
    }
    EXPECT_EQ(polygon_fault(l_shape()), "");
    EXPECT_EQ(polygon_fault(Points{{0, 0}, {1, 0}, {2, 0}, {2, 1}}), "") << "a corner of 180 degrees is harmless";
}

} // namespace
} // namespace nappe
