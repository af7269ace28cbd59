// Limits of made-up wedges at known angles, and the trishear model against its own properties.
#include "core/measures/fault_zone.hpp"
#include "core/measures/trishear.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <random>

namespace nappe::fault_zone_test {
namespace {

const Vec<2> drive(0.3, 0.2);
const FieldGrid grid{0.5, -100, -4, 201, 50}; // x in [-50, 50], y in [-2, 22.5]
constexpr double top = 20;

/// Material between 0 and `top`, with these velocities.
std::vector<FieldNode> nodes_of(const std::function<Vec<2>(const Vec<2>&)>& velocity) {
    std::vector<FieldNode> nodes;
    for (std::int64_t j = 0; j < grid.n_y; ++j) {
        for (std::int64_t i = 0; i < grid.n_x; ++i) {
            const Vec<2> x(grid.x(i), grid.y(j));
            const bool inside = x[1] >= 0 && x[1] <= top;
            const Vec<2> v = inside ? velocity(x) : Vec<2>::Constant(std::numeric_limits<double>::quiet_NaN());
            nodes.push_back({inside ? 0.83 : 0.0, {v[0], v[1]}, {}, 0});
        }
    }
    return nodes;
}

Surface flat_surface() {
    auto surface = empty_surface(1, -50, 50);
    std::fill(surface.height.begin(), surface.height.end(), top);
    return surface;
}

/// Between straight lines through (2, 0) at the angles given, the velocity falls linearly in x from V0 to nought.
Vec<2> wedge(const Vec<2>& x, double left, double right) {
    const double x_left = 2 + x[1] / std::tan(left), x_right = 2 + x[1] / std::tan(right);
    const double share = x_right > x_left ? (x_right - x[0]) / (x_right - x_left) : x[0] < x_left ? 1 : 0;
    return std::clamp(share, 0.0, 1.0) * drive;
}

const ZoneRule rule{drive, 0.1, 0, 3};

TEST(FaultZone, LimitsOfALinearWedgeAreWhereTheToleranceSays) {
    const double left = 2.0, right = 0.5;
    const auto nodes = nodes_of([&](const auto& x) { return wedge(x, left, right); });
    const auto points = zone_points(grid, {0, grid.n_y}, nodes, flat_surface(), rule);
    // Rows from 3 to 17, half a metre apart; the wedge is wide there, and linear, so interpolation is exact.
    ASSERT_EQ(points.left.size(), 29u);
    ASSERT_EQ(points.right.size(), 29u);
    // A tenth of the way into the wedge: the cotangents mix.
    const double cot_left = 1 / std::tan(left), cot_right = 1 / std::tan(right);
    const auto l = zone_line(points.left, rule, grid.spacing);
    const auto r = zone_line(points.right, rule, grid.spacing);
    EXPECT_NEAR(l.angle, std::atan2(1, 0.9 * cot_left + 0.1 * cot_right), 1e-10);
    EXPECT_NEAR(r.angle, std::atan2(1, 0.1 * cot_left + 0.9 * cot_right), 1e-10);
    EXPECT_NEAR(l.x, 2, 1e-10);
    EXPECT_NEAR(r.x, 2, 1e-10);
    EXPECT_NEAR(l.residual, 0, 1e-10);
    EXPECT_EQ(l.points, 29);
}

TEST(FaultZone, TheLineIsPlacedAtTheHeightOfTheTip) {
    const std::vector<FitPoint> points = {{3, 5}, {4, 5.5}, {5, 6}, {6, 6.5}};
    const auto line = zone_line(points, {drive, 0.1, 2, 3}, grid.spacing);
    EXPECT_NEAR(line.x, 4.5, 1e-12);
    EXPECT_NEAR(line.angle, std::atan2(2, 1), 1e-12);
}

TEST(FaultZone, ABlockThatLagsHidesNothingBehindIt) {
    // A patch in the rigid block that stands still: the limit is where rigid motion first ends.
    const auto nodes =
        nodes_of([&](const auto& x) { return std::abs(x[0] + 20) < 2 ? Vec<2>(0, 0) : wedge(x, 1.8, 0.6); });
    const auto points = zone_points(grid, {0, grid.n_y}, nodes, flat_surface(), rule);
    for (const auto& point : points.left) {
        EXPECT_NEAR(point.value, -22, grid.spacing);
    }
}

TEST(FaultZone, OneAvalancheGrainDoesNotMoveTheLine) {
    const auto clean = nodes_of([&](const auto& x) { return wedge(x, 1.8, 0.6); });
    auto dirty = clean;
    dirty[grid.node(190, 20)].v = {5, 5}; // far right, in one row
    const auto of = [&](const auto& nodes) {
        return zone_line(zone_points(grid, {0, grid.n_y}, nodes, flat_surface(), rule).right, rule, grid.spacing);
    };
    EXPECT_NEAR(of(dirty).angle, of(clean).angle, 1e-10);
    EXPECT_EQ(of(dirty).points, of(clean).points - 1);
}

TEST(FaultZone, RowsWithoutALimitHaveNoPoint) {
    const auto count = [&](const auto& velocity, const ZoneRule& with) {
        const auto points = zone_points(grid, {0, grid.n_y}, nodes_of(velocity), flat_surface(), with);
        return points.left.size() + points.right.size();
    };
    const auto rigid = [](const auto&) { return drive; };
    const auto rest = [](const auto&) { return Vec<2>(0, 0); };
    EXPECT_EQ(count(rigid, rule), 0u);
    EXPECT_EQ(count(rest, rule), 0u);
    EXPECT_EQ(count(rest, {Vec<2>(0, 0), 0.1, 0, 3}), 0u); // nothing drives
    const auto none = zone_line({}, rule, 0.5);
    EXPECT_TRUE(std::isnan(none.angle) && std::isnan(none.x) && none.points == 0);
}

TEST(FaultZone, RowsOfRanksJoinToTheWhole) {
    const auto nodes = nodes_of([&](const auto& x) { return wedge(x, 1.8, 0.6); });
    const auto whole = zone_points(grid, {0, grid.n_y}, nodes, flat_surface(), rule);
    std::vector<FitPoint> joined;
    for (std::int64_t j = 0; j < grid.n_y; j += 13) {
        const GridRows rows{j, std::min<std::int64_t>(13, grid.n_y - j)};
        const auto part = std::span(nodes).subspan(grid.node(0, j), static_cast<std::size_t>(rows.count * grid.n_x));
        const auto points = zone_points(grid, rows, part, flat_surface(), rule);
        joined.insert(joined.end(), points.left.begin(), points.left.end());
    }
    ASSERT_EQ(joined.size(), whole.left.size());
    for (std::size_t k = 0; k < joined.size(); ++k) {
        EXPECT_EQ(joined[k].at, whole.left[k].at);
        EXPECT_EQ(joined[k].value, whole.left[k].value);
    }
}

const Trishear model{{1.5, -0.5}, 0.7, 2.5};

const TrishearBounds bounds{.tip = {0, 0}, .reach = 10};

TEST(Trishear, HasNoDivergence) {
    const double d = 1e-5;
    for (const double x : {3.0, 8.0, 20.0}) {
        for (const double angle : {0.1, 0.3, 0.5, 0.7, 0.9}) {
            const Vec<2> at = model.tip + x * Vec<2>(std::cos(angle), std::sin(angle));
            const double dx = trishear_velocity(model, drive, at + Vec<2>(d, 0))[0] -
                              trishear_velocity(model, drive, at - Vec<2>(d, 0))[0];
            const double dy = trishear_velocity(model, drive, at + Vec<2>(0, d))[1] -
                              trishear_velocity(model, drive, at - Vec<2>(0, d))[1];
            EXPECT_NEAR((dx + dy) / (2 * d), 0, 1e-8); // d² times a third derivative, and round-off over d
        }
    }
}

TEST(Trishear, IsContinuousAtBothLimits) {
    const double fault = std::atan2(drive[1], drive[0]), half = std::atan(model.m);
    const auto at = [&](double angle) {
        return trishear_velocity(model, drive, model.tip + 7 * Vec<2>(std::cos(angle), std::sin(angle)));
    };
    EXPECT_LT((at(fault + half - 1e-9) - drive).norm(), 1e-8);
    EXPECT_LT(at(fault - half + 1e-9).norm(), 1e-8);
    EXPECT_EQ(at(fault + half + 0.1), drive);
    EXPECT_EQ(at(fault - half - 0.1), Vec<2>(0, 0));
    EXPECT_LT((at(fault + 1e-12) - at(fault - 1e-12)).norm(), 1e-4); // |eta|^(1/s) is steep on the fault itself
}

TEST(Trishear, IsLinearAcrossTheZoneForSOne) {
    const Trishear linear{{0, 0}, 0.5, 1};
    const Vec<2> along(1, 0);
    EXPECT_NEAR(trishear_velocity(linear, along, {4, 1})[0], 0.75, 1e-15); // u = 1/2 above
    EXPECT_NEAR(trishear_velocity(linear, along, {4, -1})[0], 0.25, 1e-15);
    EXPECT_NEAR(trishear_velocity(linear, along, {4, 1})[1], 0.5 * 0.25 * (0.25 - 1), 1e-15);
}

TEST(Trishear, TheBlockAboveMovesWhicheverWayItGoes) {
    EXPECT_EQ(trishear_velocity(model, {-0.3, 0.2}, {-10, 40}), Vec<2>(-0.3, 0.2));
    EXPECT_EQ(trishear_velocity(model, {-0.3, 0.2}, {-40, -5}), Vec<2>(0, 0));
}

std::vector<VelocityAt> measured(const Trishear& truth, double noise) {
    std::mt19937_64 random(7);
    std::vector<VelocityAt> data;
    const auto draw = [&] { // uniform with this standard deviation
        return noise * std::sqrt(3.0) * (2 * static_cast<double>(random() >> 11) * 0x1p-53 - 1);
    };
    for (double y = 2; y <= 12; y += 0.8) {
        for (double x = -30; x <= 40; x += 0.8) {
            const Vec<2> v = trishear_velocity(truth, drive, {x, y});
            data.push_back({{x, y}, {v[0] + draw(), v[1] + draw()}});
        }
    }
    return data;
}

TEST(Trishear, TheFitFindsTheParametersOfItsOwnField) {
    for (const Trishear& truth : {model, Trishear{{-2, 1}, 0.3, 1.5}, Trishear{{3, -1}, 1.6, 5}}) {
        const auto fit = fit_trishear(measured(truth, 0), drive, bounds);
        // Levenberg–Marquardt ends at relative steps of sqrt(eps) ~ 1e-8; kinks of the field at nodes slow it down.
        EXPECT_NEAR(fit.model.tip[0], truth.tip[0], 1e-4);
        EXPECT_NEAR(fit.model.tip[1], truth.tip[1], 1e-4);
        EXPECT_NEAR(fit.model.m, truth.m, 1e-4);
        EXPECT_NEAR(fit.model.s, truth.s, 1e-3);
        EXPECT_LT(fit.residual, 1e-5);
    }
}

TEST(Trishear, TheResidualOfANoisyFieldIsTheNoise) {
    const double noise = 0.02;
    const auto data = measured(model, noise);
    const auto fit = fit_trishear(data, drive, bounds);
    // Two components, and over 1000 places: the sample's own scatter is 1 / sqrt(2 n) = 2 %, four unknowns take less.
    EXPECT_NEAR(fit.residual, std::sqrt(2.0) * noise / drive.norm(), 0.05 * std::sqrt(2.0) * noise / drive.norm());
    EXPECT_NEAR(fit.model.m, model.m, 0.05);
}

TEST(Trishear, TheResidualInsideDoesNotSeeHowMuchIsAtRest) {
    const double noise = 0.02;
    auto data = measured(model, 0);
    const auto noisy = measured(model, noise);
    std::size_t n = 0;
    for (std::size_t k = 0; k < data.size(); ++k) {
        if (trishear_inside(model, drive, {data[k].x[0], data[k].x[1]})) {
            data[k] = noisy[k];
            ++n;
        }
    }
    const auto near = fit_trishear(data, drive, bounds);
    const double all = std::sqrt(static_cast<double>(n) / static_cast<double>(data.size()));
    const double expected = std::sqrt(2.0) * noise / drive.norm();
    // About 500 places inside with two components: the sample's scatter is 3 %; the rest is exactly on the model.
    EXPECT_NEAR(near.residual_inside, expected, 0.1 * expected);
    EXPECT_NEAR(near.residual, all * expected, 0.1 * all * expected);
    for (double x = 60; x <= 200; x += 0.8) { // far ahead, at rest
        data.push_back({{x, -60}, {0, 0}});
    }
    const auto far = fit_trishear(data, drive, bounds);
    EXPECT_NEAR(far.residual_inside, near.residual_inside, 0.02 * expected);
    EXPECT_LT(far.residual, 0.98 * near.residual);
}

TEST(Trishear, ATipIsNotSoughtBeyondItsBounds) {
    // Parallel shear, which a wedge from infinity fits best.
    std::vector<VelocityAt> data;
    const Vec<2> up(-drive[1], drive[0]);
    for (double y = 2; y <= 12; y += 0.8) {
        for (double x = -30; x <= 40; x += 0.8) {
            const double share = std::clamp(0.5 + up.dot(Vec<2>(x, y)) / up.norm() / 6, 0.0, 1.0);
            data.push_back({{x, y}, {share * drive[0], share * drive[1]}});
        }
    }
    const auto fit = fit_trishear(data, drive, bounds);
    EXPECT_LE(fit.model.tip.cwiseAbs().maxCoeff(), 10);
    EXPECT_LT(fit.model.tip[0], -5); // upstream, as far as it may
    EXPECT_LT(fit.residual, 0.1);
}

TEST(Trishear, WithoutDataOrDriveThereIsNoFit) {
    EXPECT_TRUE(std::isnan(fit_trishear({}, drive, bounds).residual));
    EXPECT_TRUE(std::isnan(fit_trishear(measured(model, 0), {0, 0}, bounds).model.s));
}

} // namespace
} // namespace nappe::fault_zone_test
