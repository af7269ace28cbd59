// Coarse-grained fields of flows whose gradient is known.
#include "core/measures/coarse_grain.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace nappe {
namespace {

constexpr double radius = 0.5;

/// Disks on a hexagonal lattice, all contacts closed: solid fraction pi / (2 sqrt 3) = 0.9069.
std::vector<FlowGrain> lattice(int n, const std::function<Vec<2>(const Vec<2>&)>& velocity) {
    std::vector<FlowGrain> grains;
    for (int row = 0; row < n; ++row) {
        for (int k = 0; k < n; ++k) {
            const Vec<2> x(2 * radius * (k + 0.5 * (row % 2)), std::sqrt(3.0) * radius * row);
            const Vec<2> v = velocity(x);
            const double area = std::numbers::pi * radius * radius;
            grains.push_back(
                {static_cast<GlobalId>(grains.size()), {x[0], x[1]}, {v[0], v[1]}, 2800 * area, area, x[0]});
        }
    }
    return grains;
}

constexpr int n = 40;
const FieldGrid grid{2 * radius, -2, -2, 45, 40};
const GridRows all_rows{0, grid.n_y};

std::vector<FieldNode> fields_of(const std::vector<FlowGrain>& grains, double range = 8 * radius) {
    CoarseGrain sums(grid, all_rows, range);
    for (const auto& grain : grains) {
        sums.add(grain);
    }
    return sums.fields();
}

/// Calls check(node, place) for the nodes a whole range inside the lattice.
void for_each_inner(const std::vector<FieldNode>& nodes, double range,
                    const std::function<void(const FieldNode&, const Vec<2>&)>& check) {
    int n_checked = 0;
    const double width = 2 * radius * (n - 1), height = std::sqrt(3.0) * radius * (n - 1);
    for (std::int64_t j = 0; j < grid.n_y; ++j) {
        for (std::int64_t i = 0; i < grid.n_x; ++i) {
            const Vec<2> x(grid.x(i), grid.y(j));
            if (x.minCoeff() > range && x[0] < width - range && x[1] < height - range) {
                check(nodes[grid.node(i, j)], x);
                ++n_checked;
            }
        }
    }
    EXPECT_GT(n_checked, 500);
}

// A sum over a lattice is the integral but for the kernel's Fourier transform at the lattice's wave vectors (Poisson).
// The six shortest have k w = 4 pi / sqrt(3) w / (2 radius) = 29, the six next sqrt(3) times that; there the transform
// (numerically) is -1.4e-5 and 6e-6, so that at most this share of the density is left:
constexpr double discreteness = 6 * (1.45e-5 + 0.62e-5);
// A derivative of the sum brings a factor k, a velocity that grows over the kernel's range a factor w.
constexpr double of_gradient = 29 * std::numbers::sqrt3 * discreteness;

TEST(CoarseGrain, TheKernelIsNormalisedInThePlane) {
    const double range = 1.7;
    double integral = 0;
    const int steps = 20000;
    for (int k = 0; k < steps; ++k) {
        const double q = (k + 0.5) / steps;
        integral += 2 * std::numbers::pi * q * range * lucy(q, range) * range / steps;
    }
    EXPECT_NEAR(integral, 1.0, 1e-8); // midpoint rule: error of the order of steps^-2
}

TEST(CoarseGrain, SolidFractionOfALatticeIsItsOwn) {
    const auto nodes = fields_of(lattice(n, [](const auto&) { return Vec<2>(0, 0); }));
    const double expected = std::numbers::pi / (2 * std::sqrt(3.0));
    for_each_inner(nodes, 8 * radius, [&](const FieldNode& node, const Vec<2>&) {
        EXPECT_NEAR(node.solid_fraction, expected, discreteness * expected);
    });
}

TEST(CoarseGrain, AUniformFlowHasNoGradientEvenAtTheEdge) {
    const auto nodes = fields_of(lattice(n, [](const auto&) { return Vec<2>(3, -2); }));
    int n_inside = 0;
    for (const auto& node : nodes) {
        if (node.solid_fraction >= least_solid_fraction) {
            ++n_inside;
            EXPECT_NEAR(node.v[0], 3, 1e-13); // round-off of a hundred terms
            EXPECT_NEAR(node.v[1], -2, 1e-13);
            EXPECT_NEAR(node.shear_rate, 0, 1e-12);
        } else {
            EXPECT_TRUE(std::isnan(node.v[0]) && std::isnan(node.gradient[3]) && std::isnan(node.shear_rate));
        }
    }
    EXPECT_GT(n_inside, n * n / 2);
    EXPECT_LT(n_inside, static_cast<int>(nodes.size())); // the grid reaches beyond
}

TEST(CoarseGrain, AnAffineFlowHasItsGradient) {
    Eigen::Matrix2d g;
    g << 0.2, -0.5, 0.9, 0.1;
    const auto nodes = fields_of(lattice(n, [&](const auto& x) { return Vec<2>(g * x); }));
    for_each_inner(nodes, 8 * radius, [&](const FieldNode& node, const Vec<2>& x) {
        const Vec<2> v = g * x;
        for (std::size_t k = 0; k < 2; ++k) {
            EXPECT_NEAR(node.v[k], v[static_cast<int>(k)], discreteness * g.norm() * 8 * radius);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            EXPECT_NEAR(node.gradient[k], g(static_cast<int>(k / 2), static_cast<int>(k % 2)), of_gradient);
        }
        EXPECT_NEAR(node.shear_rate, std::hypot(0.2 - 0.1, -0.5 + 0.9), 2 * of_gradient);
    });
}

TEST(CoarseGrain, ARigidRotationDoesNotShear) {
    const double omega = 1.5;
    const auto nodes = fields_of(lattice(n, [&](const auto& x) { return Vec<2>(-omega * x[1], omega * x[0]); }));
    for_each_inner(nodes, 8 * radius, [&](const FieldNode& node, const Vec<2>&) {
        EXPECT_NEAR(node.shear_rate, 0, 2 * omega * of_gradient);
        EXPECT_NEAR((node.gradient[2] - node.gradient[1]) / 2, omega, omega * of_gradient);
    });
}

TEST(CoarseGrain, SimpleShearHasItsRate) {
    const auto nodes = fields_of(lattice(n, [](const auto& x) { return Vec<2>(0.7 * x[1], 0); }));
    for_each_inner(nodes, 8 * radius, [&](const FieldNode& node, const Vec<2>&) {
        EXPECT_NEAR(node.shear_rate, 0.7, 2 * 0.7 * of_gradient);
    });
}

TEST(CoarseGrain, RowsComputedApartHaveTheSameBits) {
    const auto grains = lattice(n, [](const auto& x) { return Vec<2>(std::sin(x[0]), std::cos(3 * x[1])); });
    const auto whole = fields_of(grains);
    for (std::int64_t j = 0; j < grid.n_y; j += 7) {
        const GridRows rows{j, std::min<std::int64_t>(7, grid.n_y - j)};
        CoarseGrain sums(grid, rows, 8 * radius);
        for (const auto& grain : grains) {
            sums.add(grain);
        }
        const auto part = sums.fields();
        for (std::size_t k = 0; k < part.size(); ++k) {
            const auto& expected = whole[grid.node(0, j) + k];
            ASSERT_EQ(part[k].solid_fraction, expected.solid_fraction);
            ASSERT_TRUE(part[k].gradient == expected.gradient || std::isnan(expected.gradient[0]));
        }
    }
}

TEST(CoarseGrain, CumulativeStrainIsTheMeanAroundANode) {
    // The strain of the lattice's grains is their x: its mean over a symmetric kernel is x itself.
    const auto grains = lattice(n, [](const auto&) { return Vec<2>(0, 0); });
    const auto strain = coarse_strain(grid, all_rows, 8 * radius, grains);
    const auto nodes = fields_of(grains);
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        ASSERT_EQ(std::isnan(strain[k]), std::isnan(nodes[k].v[0]));
    }
    const double middle = 20 * radius;
    EXPECT_NEAR(*between_nodes(grid, strain, {middle, middle}), middle, discreteness * 8 * radius);
}

TEST(CoarseGrain, BetweenNodesIsBilinearAndLeavesOutWhatIsOutside) {
    const FieldGrid small{0.5, 2, -1, 2, 2}; // nodes at x 1, 1.5 and y -0.5, 0
    const std::vector<double> plane{1, 2, 10, 11};
    EXPECT_DOUBLE_EQ(*between_nodes(small, plane, {1.125, -0.25}), 0.75 * 5.5 + 0.25 * 6.5);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_DOUBLE_EQ(*between_nodes(small, std::vector<double>{1, nan, nan, nan}, {1.25, -0.25}), 1);
    EXPECT_FALSE(between_nodes(small, std::vector<double>{nan, nan, nan, nan}, {1.25, -0.25}));
    EXPECT_FALSE(between_nodes(small, plane, {3, 3}));
}

} // namespace
} // namespace nappe
