// Sets of grains whose figures are known by hand: lattices, pairs, chains. Impulses here are of a step of 0.01 s.
#include "core/measures/backbone.hpp"
#include "core/measures/local_fraction.hpp"
#include "core/measures/set_measures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nappe {
namespace {

constexpr double h = 0.01, pi = std::numbers::pi;

/// A frame by hand, measured as one rank does it.
class Packing {
public:
    GlobalId grain(double x, double y, double radius) {
        FrameGrain<2> row;
        row.grain.id = static_cast<GlobalId>(grains_.size());
        row.grain.x = {x, y};
        row.grain.radius = radius;
        grains_.push_back(row);
        return row.grain.id;
    }

    /// Between two grains where they stand. @param force normal and tangential [N]
    void contact(GlobalId a, GlobalId b, double normal, double tangential = 0) {
        const auto [lo, hi] = std::minmax(a, b);
        const auto &p = at(lo), &q = at(hi);
        const double dx = p.x[0] - q.x[0], dy = p.x[1] - q.x[1], d = std::hypot(dx, dy);
        contacts_.push_back(row(lo, hi, {dx / d, dy / d}, d - p.radius - q.radius, normal, tangential));
    }

    void wall_contact(GlobalId a, const std::array<double, 2>& n, double normal) {
        contacts_.push_back(row(a, wall_key + static_cast<GlobalId>(contacts_.size()), n, 0, normal, 0));
    }

    std::vector<ContactSide<2>> sides() const {
        std::vector<ContactSide<2>> all;
        for (const auto& c : contacts_) {
            all.push_back(side_of_lo(c));
            if (c.hi < wall_key) {
                all.back().partner_radius = at(c.hi).radius;
                all.push_back(side_of_hi(c));
                all.back().partner_radius = at(c.lo).radius;
            }
        }
        std::sort(all.begin(), all.end(), [](const auto& p, const auto& q) {
            return p.grain != q.grain ? p.grain < q.grain : p.partner < q.partner;
        });
        return all;
    }

    /// Of the grains that `in` says. @param range of the kernel [m]
    template <class In>
    SetSums<2> sums(double range, In in) const {
        const auto all = sides();
        const auto loads = grain_loads<2>(grains_, all);
        Backbone backbone(0, grains_.size(), std::span<const ContactSide<2>>(all));
        EXPECT_TRUE(backbone.take_rattlers().empty());
        std::vector<FieldGrain> field;
        for (const auto& g : grains_) {
            field.push_back({g.grain.id, g.grain.x[0], g.grain.x[1], g.grain.radius, true});
        }
        const auto fractions = local_solid_fractions(field, range);
        SetSums<2> set;
        for (std::size_t i = 0; i < grains_.size(); ++i) {
            if (in(grains_[i].grain)) {
                set.add({&grains_[i], &loads[i], backbone.is_rattler(i), backbone.contacts(i), fractions[i]});
            }
        }
        return set;
    }

    SetFigures figures(const SetReference<2>& at_start) const {
        return sums(1, [](const auto&) { return true; }).figures(at_start, h);
    }

    std::vector<FrameGrain<2>>& grains() { return grains_; }

private:
    const GrainRow<2>& at(GlobalId id) const { return grains_[static_cast<std::size_t>(id)].grain; }

    static FrameContact<2> row(GlobalId lo, GlobalId hi, const std::array<double, 2>& n, double gap, double normal,
                               double tangential) {
        FrameContact<2> c;
        c.lo = lo;
        c.hi = hi;
        c.normal = n;
        c.gap = gap;
        c.r_n = normal * h;
        c.r_t = {tangential * h};
        return c;
    }

    std::vector<FrameGrain<2>> grains_;
    std::vector<FrameContact<2>> contacts_;
};

/// The inner grains of a lattice: those whose kernel does not reach the border.
template <class Row>
bool is_inner(const Row& g, double half) {
    return std::abs(g.x[0]) < half && std::abs(g.x[1]) < half;
}

/// Every grain of radius r touches four at distance 2 r, with forces f_x along x and f_y along y, in (2 r)² of room:
/// sum f ⊗ arm = diag(2 f_x r, 2 f_y r), so sigma = diag(f_x, f_y) / (2 r). Two contacts a grain (four halves), one
/// along each axis: the fabric is the same both ways, 1/(2 r)². The field at a centre is the lattice sum of a kernel
/// that is smooth on the scale of the lattice: Poisson's formula leaves 4 Ŵ(2 pi/d) of the mean as largest error, and Ŵ
/// falls with the power 4.5 of d/w: the first terms give 3e-4 at w = 5 d.
TEST(Sets, SquareLattice) {
    const double r = 0.25, d = 2 * r, fx = 3e3, fy = 5e3;
    constexpr int n = 25;
    Packing packing;
    for (int k = 0; k < n * n; ++k) {
        packing.grain((k % n - n / 2) * d, (k / n - n / 2) * d, r);
        if (k % n > 0) {
            packing.contact(k, k - 1, fx);
        }
        if (k >= n) {
            packing.contact(k, k - n, fy);
        }
    }
    auto set = packing.sums(5 * d, [&](const auto& g) { return is_inner(g, 6.5 * d); });
    const auto f = set.figures({pi / 4, set.extent()}, h);
    EXPECT_EQ(f.grains, 13 * 13);
    EXPECT_NEAR(f.p, (fx + fy) / (4 * r), 1e-10 * fy);
    EXPECT_NEAR(f.q, (fy - fx) / (4 * r), 1e-10 * fy);
    EXPECT_NEAR(f.angle, pi / 2, 1e-14);
    EXPECT_NEAR(f.fabric_1, 1 / (d * d), 1e-13);
    EXPECT_NEAR(f.fabric_2, 1 / (d * d), 1e-13);
    EXPECT_NEAR(f.anisotropy, 0, 1e-13);
    EXPECT_NEAR(f.anisotropy_normalised, 0, 1e-14);
    EXPECT_EQ(f.coordination, 4);
    EXPECT_EQ(f.coordination_backbone, 4);
    EXPECT_EQ(f.rattlers, 0);
    EXPECT_NEAR(f.solid_fraction, pi / 4, 5e-4 * pi / 4);
    EXPECT_EQ(f.lambda_x, 1);
}

/// Six neighbours with the force f each, in 2 sqrt(3) r² of room: sum of n ⊗ n is 3 times unity, so p = 3 f r over the
/// room = sqrt(3) f / (2 r), and no direction is preferred: q = 0, the normalised fabric is half of unity.
TEST(Sets, HexagonalLattice) {
    const double r = 0.25, f_n = 2e3;
    constexpr int n = 25;
    Packing packing;
    for (int k = 0; k < n * n; ++k) {
        const int row = k / n, column = k % n;
        packing.grain((column - n / 2 + 0.5 * (row % 2)) * 2 * r, (row - n / 2) * std::sqrt(3.0) * r, r);
        if (column > 0) {
            packing.contact(k, k - 1, f_n);
        }
        for (const int left : {column - 1 + row % 2, column + row % 2}) {
            if (row > 0 && left >= 0 && left < n) {
                packing.contact(k, k - column - n + left, f_n);
            }
        }
    }
    auto set = packing.sums(10 * r, [&](const auto& g) { return is_inner(g, 10 * r); });
    const auto f = set.figures({pi / (2 * std::sqrt(3.0)), set.extent()}, h);
    EXPECT_GT(f.grains, 100);
    EXPECT_NEAR(f.p, std::sqrt(3.0) * f_n / (2 * r), 1e-10 * f_n);
    EXPECT_NEAR(f.q, 0, 1e-10 * f_n);
    EXPECT_NEAR(f.fabric_1, 1.5 / (2 * std::sqrt(3.0) * r * r), 1e-12);
    EXPECT_NEAR(f.anisotropy_normalised, 0, 1e-14);
    EXPECT_EQ(f.coordination, 6);
    EXPECT_NEAR(f.solid_fraction, pi / (2 * std::sqrt(3.0)), 5e-4); // as above
}

/// One contact at angle a between centres 0.5 apart: sum f ⊗ arm = 0.5 (f_n n + f_t t) ⊗ n, symmetrised 0.5 (f_n n ⊗ n
/// + f_t (t ⊗ n + n ⊗ t) / 2): p = 0.5 f_n / 2V, q = 0.5 sqrt(f_n² + f_t²) / 2V, and the larger principal stress is
/// turned by atan(f_t / f_n) / 2 from n.
TEST(Sets, PairThatIsTurned) {
    const double volume = pi * (0.04 + 0.09) / 0.8, f_n = 40, f_t = 9;
    for (const double degrees : {-89.0, -60.0, -10.0, 0.0, 30.0, 77.0, 90.0}) {
        SCOPED_TRACE(degrees);
        const double a = degrees * pi / 180;
        Packing packing;
        packing.grain(0, 0, 0.2);
        packing.grain(-0.5 * std::cos(a), -0.5 * std::sin(a), 0.3);
        packing.contact(0, 1, f_n, f_t);
        const auto f = packing.figures({0.8, {1, 1}});
        EXPECT_NEAR(f.p, 0.25 * f_n / volume, 1e-12 * f_n / volume);
        EXPECT_NEAR(f.q, 0.25 * std::hypot(f_n, f_t) / volume, 1e-12 * f_n / volume);
        EXPECT_NEAR(std::remainder(f.angle - a - 0.5 * std::atan(f_t / f_n), pi), 0, 1e-13);
        EXPECT_NEAR(std::remainder(f.fabric_angle - a, pi), 0, 1e-13);
        EXPECT_GT(f.angle, -pi / 2);
        EXPECT_LE(f.angle, pi / 2);
        EXPECT_NEAR(f.fabric_1, 1 / volume, 1e-13);
        EXPECT_NEAR(f.fabric_2, 0, 1e-13);
        EXPECT_NEAR(f.anisotropy, 0.5 / volume, 1e-13);
        EXPECT_NEAR(f.anisotropy_normalised, 0.5, 1e-14);
    }
}

/// Turned from y by less than round-off to either side: one of the two would be -pi/2.
TEST(Sets, AngleOfTheYAxisIsPlusPiHalf) {
    for (const double x : {-1e-20, 0.0, 1e-20}) {
        Packing packing;
        packing.grain(0, 0, 0.2);
        packing.grain(x, 0.4, 0.2);
        packing.contact(0, 1, 10);
        EXPECT_EQ(packing.figures({0.8, {1, 1}}).angle, pi / 2) << x;
    }
}

TEST(Sets, AffineMotionStretchesCells) {
    Packing packing;
    for (const auto& [x, y] : {std::pair{1.0, 1.0}, {2.0, 4.0}, {5.0, 3.0}, {3.0, -2.0}}) {
        packing.grain(x, y, 0.1);
    }
    const auto everything = [](const auto&) { return true; };
    const SetReference<2> at_start{0.8, packing.sums(1, everything).extent()};
    EXPECT_EQ(at_start.extent[0], 4);
    EXPECT_EQ(at_start.extent[1], 6);
    for (auto& row : packing.grains()) { // x' = 1.5 x + 7, y' = y / 2: extents are multiplied
        row.grain.x = {1.5 * row.grain.x[0] + 7, row.grain.x[1] / 2};
    }
    const auto f = packing.figures(at_start);
    EXPECT_EQ(f.lambda_x, 1.5);
    EXPECT_EQ(f.lambda_y, 0.5);
    EXPECT_TRUE(std::isnan(f.angle) && std::isnan(f.anisotropy_normalised) && std::isnan(f.overlap_mean));
    EXPECT_EQ(f.p, 0);
    EXPECT_EQ(f.coordination, 0);
    EXPECT_EQ(f.rattlers, 4);
    EXPECT_TRUE(std::isnan(f.coordination_backbone));
}

/// Far from each other, phi at a centre is what the grain's own area gives: pi r² W(0) = 5 (r/w)².
TEST(Sets, SolidFractionOfGrainsThatAreAlone) {
    Packing packing;
    packing.grain(0, 0, 0.1);
    packing.grain(10, -10, 0.2);
    auto set = packing.sums(2, [](const auto&) { return true; });
    // sum A / sum(A / phi), phi = 5 r²/4 and A = pi r²: 2 grains with A/phi = 4 pi / 5 each.
    EXPECT_NEAR(set.solid_fraction(), pi * 0.05 / (2 * 4 * pi / 5), 1e-15);
}

/// A ring of three, from which a tail of four hangs, ending free; a chain of two from the ring to a wall; one grain on
/// the wall; one alone. The tail goes grain by grain, the chain has two contacts everywhere and stays.
class RingWithTail : public testing::Test {
protected:
    RingWithTail() {
        // By number: tail 0 1 2 3, ring 4 5 6, chain 7 8, on the wall 9, alone 10. They need not stand where they
        // touch.
        for (int k = 0; k < 11; ++k) {
            packing.grain(k, k % 2, 0.5);
        }
        for (const auto& [a, b] : {std::pair{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}, {5, 6}, {6, 4}, {6, 7}, {7, 8}}) {
            packing.contact(a, b, a == 1 ? -1.0 : 1.0); // one pulls: it holds as well
        }
        packing.wall_contact(8, {0, 1}, 1);
        packing.wall_contact(9, {0, 1}, 1);
        packing.contact(9, 10, 0); // touches without an impulse
    }

    Packing packing;
    const std::vector<bool> rattles{true, true, true, true, false, false, false, false, false, true, true};
    const std::vector<std::int32_t> holds{0, 0, 0, 0, 2, 2, 3, 2, 2, 0, 0};
};

TEST_F(RingWithTail, LosesItsTail) {
    const auto f = packing.figures({0.8, {1, 1}});
    EXPECT_EQ(f.rattlers, 6);
    // 9 contacts of two grains and 2 of one, each grain counting its own.
    EXPECT_EQ(f.coordination, 20.0 / 11);
    EXPECT_EQ(f.coordination_backbone, 11.0 / 5);
}

TEST_F(RingWithTail, AnyBlocksFindTheSame) {
    const auto sides = packing.sides();
    for (const std::vector<GlobalId>& cuts :
         {std::vector<GlobalId>{0, 11}, {0, 2, 11}, {0, 1, 5, 11}, {0, 3, 4, 7, 11}}) {
        std::vector<Backbone> blocks;
        for (std::size_t b = 0; b + 1 < cuts.size(); ++b) {
            const auto before = [](const ContactSide<2>& side, GlobalId id) { return side.grain < id; };
            const auto begin = std::lower_bound(sides.begin(), sides.end(), cuts[b], before);
            const auto end = std::lower_bound(sides.begin(), sides.end(), cuts[b + 1], before);
            blocks.emplace_back(cuts[b], static_cast<std::size_t>(cuts[b + 1] - cuts[b]),
                                std::span<const ContactSide<2>>(begin, end));
        }
        const auto block_of = [&](GlobalId id) {
            return static_cast<std::size_t>(std::upper_bound(cuts.begin(), cuts.end(), id) - cuts.begin() - 1);
        };
        for (bool told = true; told;) {
            told = false;
            for (auto& block : blocks) {
                for (const GlobalId id : block.take_rattlers()) {
                    blocks[block_of(id)].lose_contact(id);
                    told = true;
                }
            }
        }
        for (GlobalId id = 0; id < 11; ++id) {
            const auto row = static_cast<std::size_t>(id - cuts[block_of(id)]);
            EXPECT_EQ(blocks[block_of(id)].is_rattler(row), rattles[static_cast<std::size_t>(id)]) << id;
            EXPECT_EQ(blocks[block_of(id)].contacts(row), holds[static_cast<std::size_t>(id)]) << id;
        }
    }
}

/// Two sets that share a border add up to the whole: stress and fabric times volume, contacts, area.
TEST(Sets, AreAdditive) {
    Packing packing;
    for (int k = 0; k < 6; ++k) {
        packing.grain(0.9 * k, 0.3 * (k % 2), 0.4 + 0.02 * k);
        if (k > 0) {
            packing.contact(k, k - 1, 10.0 + k, 2.0 - k);
        }
    }
    packing.wall_contact(0, {1, 0}, 7);
    const auto volume_times = [&](auto in, auto get) {
        auto set = packing.sums(1, in);
        return get(set.figures({1, {1, 1}}, h)) * set.area(); // phi0 = 1: V is the grains' own area
    };
    const auto left = [](const auto& g) { return g.id < 3; };
    const auto right = [](const auto& g) { return g.id >= 3; };
    const auto all = [](const auto&) { return true; };
    const auto trace = [](const SetFigures& f) { return 2 * f.p; };
    const auto contacts = [](const SetFigures& f) { return f.fabric_1 + f.fabric_2; }; // n has the length 1
    EXPECT_NEAR(volume_times(left, trace) + volume_times(right, trace), volume_times(all, trace), 1e-11);
    EXPECT_NEAR(volume_times(left, contacts), 2.5 + 1, 1e-13); // the contact of 2 and 3 is half of this set
    EXPECT_NEAR(volume_times(right, contacts), 2.5, 1e-13);
    EXPECT_NEAR(volume_times(all, contacts), 6, 1e-13);
}

/// Overlaps are over the smaller radius; the mean is over contacts that carry an impulse, the largest over all.
TEST(Sets, Overlaps) {
    Packing packing;
    packing.grain(0, 0, 0.5);
    packing.grain(0.69, 0, 0.2);   // overlap 0.01: 5 % of 0.2
    packing.grain(-0.995, 0, 0.5); // 0.005: 1 %
    packing.grain(0, 0.98, 0.5);   // 0.02: 4 %, no impulse
    packing.contact(0, 1, 1);
    packing.contact(0, 2, 1);
    packing.contact(0, 3, 0);
    const auto f = packing.figures({0.8, {1, 1}});
    EXPECT_NEAR(f.overlap_mean, 0.03, 1e-14);
    EXPECT_NEAR(f.overlap_max, 0.05, 1e-14);
    const auto alone = packing.sums(1, [](const auto& g) { return g.id == 3; }).figures({0.8, {1, 1}}, h);
    EXPECT_NEAR(alone.overlap_max, 0.04, 1e-14);
}

} // namespace
} // namespace nappe
