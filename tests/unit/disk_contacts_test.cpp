// DiskContacts: which candidates a step packs, what a batch holds, and that impulses come back to their candidates.

#include "solver/disk_contacts.hpp"

#include "core/neighbours.hpp"
#include "disk_fixture.hpp"
#include "support/kernels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace nappe {
namespace {

using namespace test;

/// Packed: a gap up to 1 % of both radii, or one that twice the present approach would close; ids 1, 3, 5 … are the pairs.
TEST(DiskContacts, PacksWhatMayActInTheStep) {
    const double size = 2 * r;
    Fixture f({-0.1, 0.0, 0.0099 * size, 0.0101 * size, 0.1, 0.1, 0.1},
              {0, 0, 0, 0, 0, 1.01 * 0.09 / (2 * h), 0.99 * 0.09 / (2 * h)});
    DiskContacts contacts(f.scene, disk_kernels("portable"));
    contacts.pack(f.state, f.candidates, f.walls, h, false);
    const auto found = f.packed(contacts);
    EXPECT_TRUE(found.count(1)) << "overlap";
    EXPECT_TRUE(found.count(3)) << "touching";
    EXPECT_TRUE(found.count(5)) << "within 1 %";
    EXPECT_FALSE(found.count(7)) << "beyond 1 %";
    EXPECT_FALSE(found.count(9)) << "far and at rest";
    EXPECT_TRUE(found.count(11)) << "closes";
    EXPECT_FALSE(found.count(13)) << "closes too slowly";
    EXPECT_FALSE(found.count(0)) << "0.2 r above the floor, at rest";
    EXPECT_EQ(contacts.n_active(), 4);
    ASSERT_EQ(f.candidates.tiles.size(), 1u);
    EXPECT_EQ(contacts.n_active(0), 4);
    EXPECT_NEAR((found.at(1).n - Vec<2>(-1, 0)).norm(), 0, 1e-15) << "from b to a";

    contacts.pack(f.state, f.candidates, f.walls, h, true);
    EXPECT_EQ(contacts.n_active(), 8) << "all seven pairs and the floor's middle";
    EXPECT_TRUE(f.packed(contacts).at(0).wall);
    EXPECT_EQ(f.packed(contacts).at(0).n, (Vec<2>(0, 1)));
}

/// With restitution a contact acts only if free flight closes the gap within the step: there is no gap bias.
TEST(DiskContacts, RestitutionWaitsForTheTouch) {
    Fixture f({0.001, 0.001, -0.001, -0.001}, {1.01 * 0.001 / h, 0.99 * 0.001 / h, 0, -3}, 0.5);
    DiskContacts contacts(f.scene, disk_kernels("portable"));
    for (const bool all : {false, true}) {
        contacts.pack(f.state, f.candidates, f.walls, h, all);
        const auto found = f.packed(contacts);
        EXPECT_TRUE(found.count(1));
        EXPECT_FALSE(found.count(3)) << "not in this step";
        EXPECT_TRUE(found.count(5));
        EXPECT_TRUE(found.count(7)) << "an overlap counts, even while it opens";
    }
}

TEST(DiskContacts, NoticesWhatItShouldHavePacked) {
    Fixture f({0.1, 0.1}, {0, 0});
    DiskContacts contacts(f.scene, disk_kernels("portable"));
    contacts.pack(f.state, f.candidates, f.walls, h, false);
    EXPECT_EQ(contacts.n_active(), 0);
    EXPECT_FALSE(contacts.missed_any(f.state, f.candidates, f.walls, h));
    f.state.u[3].v[0] = 0.99 * 0.1 / h; // grain 3 is pair 1's left one
    EXPECT_FALSE(contacts.missed_any(f.state, f.candidates, f.walls, h)) << "stops short of touching";
    f.state.u[3].v[0] = 1.01 * 0.1 / h;
    EXPECT_TRUE(contacts.missed_any(f.state, f.candidates, f.walls, h));
    f.state.u[3].v[0] = 0;
    f.state.u[0].v[1] = -1.01 * 0.2 * r / h;
    EXPECT_TRUE(contacts.missed_any(f.state, f.candidates, f.walls, h)) << "the floor";
    contacts.pack(f.state, f.candidates, f.walls, h, true);
    EXPECT_FALSE(contacts.missed_any(f.state, f.candidates, f.walls, h)) << "nothing is left out";
}

TEST(DiskContacts, ImpulsesComeBackToTheirCandidates) {
    std::vector<double> gaps, approaches;
    for (int k = 0; k < 21; ++k) { // more than two batches, the last one padded; every fourth is left out
        gaps.push_back(k % 4 == 3 ? 0.1 : 0.0);
        approaches.push_back(0);
    }
    Fixture f(gaps, approaches);
    for (std::int32_t c = 0; c < f.candidates.size(); ++c) {
        f.candidates.set_impulse(c, {1.0 + c, {-0.25 * c}});
    }
    DiskContacts contacts(f.scene, disk_kernels("portable"));
    contacts.pack(f.state, f.candidates, f.walls, h, false);
    EXPECT_EQ(contacts.n_active(), 16);
    auto stored = f.candidates;
    for (std::size_t c = 0; c < stored.r_n.size(); ++c) {
        stored.set_impulse(c, {99, {99}});
    }
    contacts.store(stored);
    const auto found = f.packed(contacts);
    for (std::int32_t c = 0; c < stored.size(); ++c) {
        const auto id = f.state.id[f.candidates.a[c]];
        const bool packed = found.count(id) != 0 && f.candidates.b[c] < f.state.n_held();
        EXPECT_EQ(stored.r_n[c], packed ? 1.0 + c : 0.0) << c;
        EXPECT_EQ(stored.r_t[c][0], packed ? -0.25 * c : 0.0) << c;
        if (packed) {
            EXPECT_EQ(found.at(id).r_n, 1.0 + c);
        }
    }
}

/// A warm start: each impulse changes v by r/m, and the rim speeds of both by -2 r_t/m.
TEST(DiskContacts, AppliesImpulsesToBothBodies) {
    Fixture f({0.0}, {0});
    f.candidates.set_impulse(static_cast<std::size_t>(f.candidates.size()) - 1, {6, {-1.5}});
    ASSERT_EQ(f.state.id[f.candidates.a[f.candidates.size() - 1]], 1);
    DiskContacts contacts(f.scene, disk_kernels("portable"));
    contacts.pack(f.state, f.candidates, f.walls, h, false);
    contacts.apply(0, f.state.u);
    const auto& a = f.state.u[1]; // mass 2, n = (-1, 0), t = (0, -1)
    const auto& b = f.state.u[2]; // mass 3
    EXPECT_DOUBLE_EQ(a.v[0], -3);
    EXPECT_DOUBLE_EQ(a.v[1], 0.75);
    EXPECT_DOUBLE_EQ(a.s[0], 1.5);
    EXPECT_DOUBLE_EQ(b.v[0], 2);
    EXPECT_DOUBLE_EQ(b.v[1], -0.5);
    EXPECT_DOUBLE_EQ(b.s[0], 1);
}

/// One contact of two disks of 2 and 3 kg that close at u_n = -5 and slip at u_t = 1: W_nn = 5/6, the wanted impulses are 6 and
/// -u_t / (3 W_nn) = -0.4, well within mu r_n = 3. The residual at zero impulse is W r = (5, 3 W_nn 0.4 = 1); solved, it is 0.
TEST(DiskContacts, ResidualOfOneContact) {
    Fixture f({0.0}, {5});
    f.state.u[1].v[1] = -1; // v_t = t·(v_a - v_b), t = (0, -1)
    DiskContacts contacts(f.scene, disk_kernels("portable"));
    contacts.pack(f.state, f.candidates, f.walls, h, false);
    EXPECT_NEAR(contacts.residual(0, f.state.u).largest_squared, 26, 1e-13);
    EXPECT_NEAR(contacts.residual(0, f.state.u).sum_squared, 26, 1e-13);
    EXPECT_EQ(contacts.residual(0, f.state.u).contacts, 1);
    EXPECT_NEAR(contacts.touching_speed(0, f.state.u).first, 26, 1e-13);
    EXPECT_EQ(contacts.touching_speed(0, f.state.u).second, 1);
    contacts.relax(0, no_tile, f.state.u);
    EXPECT_NEAR(contacts.residual(0, f.state.u).largest_squared, 0, 1e-28) << "squares of round-off";
    EXPECT_NEAR(f.packed(contacts).at(1).r_n, 6, 1e-14);
    EXPECT_NEAR(f.packed(contacts).at(1).r_t, -0.4, 1e-14);
}

/// A dense block, packed, relaxed, moved and packed again: what stayed in its batches is what a fresh packing makes, and what
/// batches do is what the frozen order does contact by contact. Both to the bit.
class Block : public testing::Test {
protected:
    static constexpr int columns = 24, rows = 12;

    Block() {
        scene.materials = {{"rock", 1}};
        scene.laws = {{0, 0, 0.5, 0}};
        std::vector<GrainRecord<2>> grains;
        for (int k = 0; k < columns * rows; ++k) {
            const int column = k / rows, row = k % rows;
            GrainRecord<2> g;
            g.id = (k * 37) % (columns * rows); // ids strewn over the block
            g.x = {2 * r * column + (row % 2) * r + jitter(k), std::sqrt(3.0) * r * row + jitter(k + 1000)};
            g.u.v = {10 * jitter(k + 2000), 10 * jitter(k + 3000)};
            g.u.inv_m = 1 / (1 + std::abs(jitter(k)));
            g.mass = 1 / g.u.inv_m;
            g.radius = r;
            g.margin = 0.2 * r;
            grains.push_back(g);
        }
        const TileGrid<2> grid({0, 0}, 16 * r);
        std::sort(grains.begin(), grains.end(), [&](const auto& p, const auto& q) {
            const auto key = [&](const auto& g) { return grid.key(Vec<2>(g.x[0], g.x[1])); };
            return key(p) != key(q) ? key(p) < key(q) : p.id < q.id;
        });
        state.assign(grains, {}, 0);
        candidates = find_candidates(state, grid, walls, {});
    }

    /// Within 4 % of the radius: some pairs overlap, some sleep.
    static double jitter(int k) { return 0.04 * r * (static_cast<double>((k * 7919) % 997) / 498.5 - 1); }

    void move(double by) {
        for (LocalId i = 0; i < state.n_held(); ++i) {
            for (int d = 0; d < 2; ++d) {
                state.mid[i].x[d] += by * state.u[i].v[d];
            }
            state.u_old[i] = state.u[i];
        }
    }

    static void relax(DiskContacts& contacts, State<2>& state) {
        for (std::size_t t = 0; t < contacts.n_tiles(); ++t) {
            contacts.relax(t, no_tile, state.u);
        }
    }

    void expect_same(const State<2>& one, const State<2>& other) const {
        for (LocalId i = 0; i < state.n_held(); ++i) {
            EXPECT_EQ(one.u[i].v, other.u[i].v) << i;
            EXPECT_EQ(one.u[i].s, other.u[i].s) << i;
        }
    }

    Scene<2> scene;
    const Walls<2> walls = Walls<2>(std::vector<Wall<2>>{});
    State<2> state;
    CandidateSet<2> candidates;
};

class KeptBlock : public Block, public testing::WithParamInterface<bool> {};

/// With cohesion and without: pulls of the size of the block's impulses, bonds up to a gap that pairs come and go through.
TEST_P(KeptBlock, BatchesThatStayAreThoseOfAFreshPacking) {
    const bool cohesive = GetParam();
    scene.laws[0].gamma = cohesive ? 2 : 0;
    scene.laws[0].d_w = 0.013;
    for (const char* kernel : test::kernels_here()) {
        SCOPED_TRACE(kernel);
        DiskContacts kept(scene, disk_kernels(kernel));
        kept.set_cohesive(cohesive);
        std::set<Bond> met;
        const State<2> start = state;
        std::int64_t least = candidates.size(), most = 0;
        for (int step = 0; step < 12; ++step) {
            if (cohesive) {
                kept.find_bonds(state, candidates, walls);
                met.insert(candidates.bond.begin(), candidates.bond.end());
            }
            kept.pack(state, candidates, walls, h, false);
            auto impulses = candidates; // what the batches hold
            kept.store(impulses);
            DiskContacts fresh(scene, disk_kernels(kernel));
            fresh.set_cohesive(cohesive);
            fresh.pack(state, impulses, walls, h, false);
            ASSERT_EQ(kept.n_active(), fresh.n_active());
            least = std::min(least, kept.n_active());
            most = std::max(most, kept.n_active());
            State<2> again = state;
            for (int sweep = 0; sweep < 3; ++sweep) {
                relax(kept, state);
                relax(fresh, again);
            }
            expect_same(state, again);
            ASSERT_EQ(kept.missed_any(state, candidates, walls, h), fresh.missed_any(again, impulses, walls, h));
            // Sums depend on the order they are taken in, and that must not depend on where lanes were free.
            for (std::size_t t = 0; t < kept.n_tiles(); ++t) {
                EXPECT_EQ(kept.residual(t, state.u).sum_squared, fresh.residual(t, again.u).sum_squared);
                EXPECT_EQ(kept.touching_speed(t, state.u), fresh.touching_speed(t, again.u));
                std::vector<std::pair<LocalId, LocalId>> one, other;
                kept.for_each(t, [&](LocalId a, LocalId b, const Vec<2>&, double, double) { one.push_back({a, b}); });
                fresh.for_each(t, [&](LocalId a, LocalId b, const Vec<2>&, double, double) {
                    other.push_back({a, b});
                });
                EXPECT_EQ(one, other);
            }
            move(step % 3 == 2 ? 0.5 * h : 1e-6 * h); // nothing changes for two steps, then some
        }
        EXPECT_LT(least, most) << "no contact came or went: the case is too easy";
        EXPECT_EQ(met.size(), cohesive ? 3u : 0u) << "a state of the graph was not met";
        state = start;
    }
}

INSTANTIATE_TEST_SUITE_P(DiskContacts, KeptBlock, testing::Bool(),
                         [](const auto& tested) { return tested.param ? "cohesive" : "plain"; });

TEST_F(Block, BatchesDoWhatTheFrozenOrderDoes) {
    DiskContacts contacts(scene, disk_kernels("portable"));
    contacts.pack(state, candidates, walls, h, false);
    for (std::size_t t = 0; t < contacts.n_tiles(); ++t) {
        // Six classes or so that a batch may not straddle would leave half a batch each empty.
        EXPECT_LE(contacts.n_batches(t), (contacts.n_active(t) + n_lanes - 1) / n_lanes + 2);
    }

    // The same law written out once more, one contact after the other in the order of candidates.
    State<2> plain = state;
    std::vector<Impulse<2>> r_of(static_cast<std::size_t>(candidates.size()));
    std::map<std::pair<LocalId, LocalId>, double> bias;
    for (std::size_t t = 0; t < contacts.n_tiles(); ++t) {
        contacts.for_each(t, [&](LocalId a, LocalId b, const Vec<2>&, double, double) { bias[{a, b}] = 0; });
    }
    for (int sweep = 0; sweep < 4; ++sweep) {
        relax(contacts, state);
        for (std::int32_t c = 0; c < candidates.size(); ++c) {
            const LocalId i = candidates.a[c], j = candidates.b[c];
            if (bias.count({i, j}) == 0) {
                continue;
            }
            auto &a = plain.u[i], &b = plain.u[j];
            const double dx = plain.mid[i].x[0] - plain.mid[j].x[0], dy = plain.mid[i].x[1] - plain.mid[j].x[1];
            const double distance = std::sqrt(dx * dx + dy * dy), nx = dx / distance, ny = dy / distance;
            const double gap = distance - (r + r), m = 1.0 / (a.inv_m + b.inv_m);
            const double dvx = a.v[0] - b.v[0], dvy = a.v[1] - b.v[1];
            const double v_n = nx * dvx + ny * dvy, v_t = (nx * dvy - ny * dvx) - (a.s[0] + b.s[0]);
            const double r_n = r_of[c].n, r_t = r_of[c].t[0];
            const double new_n = std::max(0.0, r_n - (v_n + (gap > 0 ? gap / h : 0.0)) * m);
            const double limit = 0.5 * new_n;
            const double new_t = std::clamp(r_t - v_t * (m * (1.0 / 3.0)), -limit, limit);
            const double d_n = new_n - r_n, d_t = new_t - r_t;
            const double px = d_n * nx - d_t * ny, py = d_n * ny + d_t * nx;
            a.v = {a.v[0] + px * a.inv_m, a.v[1] + py * a.inv_m};
            b.v = {b.v[0] - px * b.inv_m, b.v[1] - py * b.inv_m};
            a.s[0] -= (d_t + d_t) * a.inv_m;
            b.s[0] -= (d_t + d_t) * b.inv_m;
            r_of[c] = {new_n, {new_t}};
        }
    }
    expect_same(state, plain);
}

TEST(DiskContacts, FrictionIsThatOfThePair) {
    Fixture different({0.0}, {0}, 0, 0.1);
    EXPECT_EQ(PairLaws(different.scene).friction(1, 0), 0.1);
    EXPECT_EQ(PairLaws(different.scene).friction(0, 1), 0.1);
    EXPECT_EQ(PairLaws(different.scene).friction(0, 0), 0.5);
}

TEST(DiskContacts, ReportsTheLowestGrainThatWentThrough) {
    Fixture f({0.0}, {0});
    DiskContacts contacts(f.scene, disk_kernels("portable"));
    EXPECT_EQ(contacts.pack(f.state, f.candidates, f.walls, h, false).through_wall, PackFaults::none);
    f.state.mid[0].x[1] = -0.1 * r;
    const auto faults = contacts.pack(f.state, f.candidates, f.walls, h, false);
    EXPECT_EQ(faults.through_wall, 0);
    EXPECT_EQ(faults.wall, 0);
    f.state.mid[0].x[1] = -3;
    f.state.u_old[0].v[1] = -(3 + 1.2 * r) / h; // as far as one step brings it
    EXPECT_EQ(contacts.pack(f.state, f.candidates, f.walls, h, false).through_wall, 0) << "fast";
}

} // namespace
} // namespace nappe
