// What nappe bench compares kernels with: the list-order reference must be the same physics, the triad must be what it
// is charged for.

#include "commands/bench_kernels.hpp"
#include "commands/bench_triad.hpp"
#include "support/serial_run.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

namespace nappe {
namespace {

/// Disk a left of disk b, touching; a moves right at v_x = 1 and up at v_y = 2, b is at rest. m_a = 2, m_b = 3.
struct Impact {
    explicit Impact(double mu) {
        const double inv_a = 1 / 2.0, inv_b = 1 / 3.0;
        contact = {-1, 0, 0, 1 / (inv_a + inv_b), 0, 0, 0, 1};
        u = {{1, 2, 0, inv_a}, {0, 0, 0, inv_b}};
        bench_loops().relax_list(&contact, 1, mu, u.data());
    }
    /// Of a's rim against b's, along t = (0, -1).
    double sliding() const { return -(u[0].vy - u[1].vy) - (u[0].s + u[1].s); }

    ListContact contact{};
    std::vector<ListBody> u;
};

constexpr double round_off = 1e-14; // some ten operations on numbers near 1

/// Inelastic: both have the velocity of the centre of mass along the normal, r_n = m_eff x approach = 6/5.
TEST(ListReference, ImpactWithoutFrictionIsInelastic) {
    const Impact impact(0);
    EXPECT_NEAR(impact.contact.r_n, 6.0 / 5, round_off);
    EXPECT_NEAR(impact.u[0].vx, 2.0 / 5, round_off);
    EXPECT_NEAR(impact.u[1].vx, 2.0 / 5, round_off);
    EXPECT_EQ(impact.contact.r_t, 0);
    EXPECT_EQ(impact.u[0].vy, 2);
}

/// W_tt = 3 W_nn for disks, so r_t = -v_t / (3 W_nn) = 2 x 6/5 / 3 stops the sliding if friction can give as much.
TEST(ListReference, EnoughFrictionStopsSliding) {
    const Impact impact(1);
    EXPECT_NEAR(impact.contact.r_t, 4.0 / 5, round_off);
    EXPECT_NEAR(impact.sliding(), 0, round_off);
    EXPECT_NEAR(2 * impact.u[0].vy + 3 * impact.u[1].vy, 2 * 2, round_off) << "momentum";
}

TEST(ListReference, LittleFrictionIsCoulombs) {
    const Impact impact(0.25);
    EXPECT_NEAR(impact.contact.r_t, 0.25 * impact.contact.r_n, round_off);
    EXPECT_LT(impact.sliding(), 0);
}

TEST(ListReference, ContactThatOpensHasNoImpulse) {
    ListContact c{-1, 0, 0, 1, 0.5, 0.25, 0, 1};
    std::vector<ListBody> u = {{-10, 0, 0, 0.5}, {0, 0, 0, 0.5}};
    bench_loops().relax_list(&c, 1, 0.4, u.data());
    EXPECT_EQ(c.r_n, 0);
    EXPECT_EQ(c.r_t, 0);
}

/// A low heap of some 70 disks, settled, then without a memory of its impulses, so that both orders have all to find.
struct ColdHeap {
    ColdHeap() : run(scene()) {
        run.steps(200);
        run.forget_impulses();
        problem = std::make_unique<SweepProblem>(alone, run.simulation());
    }
    static Scene<2> scene() {
        test::SceneBuilder builder(0.4);
        builder.box(20, 3.5, {RadiusLaw::Kind::uniform, 0.42, 0.56}).stage(test::solver(0.025, 100));
        return builder.scene();
    }
    bool on_wall(LocalId b) const { return b >= run.state().n_held(); }

    /// Upward, of floor and side walls together; t = (-n_y, n_x).
    double held_up_by_tiles() const {
        double sum = 0;
        const auto& contacts = problem->contacts();
        for (std::size_t t = 0; t < contacts.n_tiles(); ++t) {
            contacts.for_each(t, [&](LocalId, LocalId b, const Vec<2>& n, double r_n, double r_t) {
                sum += on_wall(b) ? r_n * n[1] + r_t * n[0] : 0.0;
            });
        }
        return sum;
    }
    double held_up_by_list() const {
        double sum = 0;
        for (const auto& c : problem->list()) {
            sum += on_wall(c.b) ? c.r_n * c.ny + c.r_t * c.nx : 0.0; // grains come first in the list's rows too
        }
        return sum;
    }

    Communicator alone = Communicator::alone();
    test::SerialRun run;
    std::unique_ptr<SweepProblem> problem;
};

/// At rest the walls carry the weight, whatever the order in which that was found. (How much of it the side walls take
/// by friction depends on the order: the forces of a box of grains are not unique.) 20,000 sweeps leave a heap of four
/// layers at round-off; 1e-9 of the weight is far above that and far below one contact's share.
TEST(ListReference, CarriesTheWeightAsTileOrderDoes) {
    ColdHeap heap;
    ASSERT_GT(heap.problem->n_contacts(), 100);
    ASSERT_EQ(heap.problem->list().size(), static_cast<std::size_t>(heap.problem->n_contacts()));
    EXPECT_EQ(heap.held_up_by_tiles(), 0) << "cold";
    EXPECT_EQ(heap.held_up_by_list(), 0) << "cold";
    heap.problem->sweep(disk_kernels(), 20000);
    heap.problem->sweep_list(20000);
    const double weight = heap.run.simulation().total_mass() * test::standard_gravity * 0.025; // times h [N s]
    EXPECT_NEAR(heap.held_up_by_tiles() / weight, 1, 1e-9);
    EXPECT_NEAR(heap.held_up_by_list() / weight, 1, 1e-9);
}

/// The list's arithmetic is the kernels', operation by operation: where there is one contact, order means nothing.
TEST(ListReference, OneContactHasTheBitsOfEveryKernel) {
    test::SceneBuilder builder(0.3);
    builder.grain(0.5, {0.013, 0.017}, {1, 0.7}, 0.9).grain(0.4, {0.7, 0.6}, {-0.4, 0.1}, -2);
    builder.stage(test::solver(0.01, 1));
    test::SerialRun run(builder.scene());
    const auto alone = Communicator::alone();
    for (const auto* kernels : kernels_everywhere(alone)) {
        SweepProblem problem(alone, run.simulation());
        ASSERT_EQ(problem.n_contacts(), 1);
        problem.sweep(*kernels, 3);
        problem.sweep_list(3);
        for (LocalId i = 0; i < 2; ++i) {
            const auto& of_tile = problem.u()[i];
            const auto& of_list = problem.list_u()[problem.list_row(i)];
            EXPECT_EQ(of_tile.v[0], of_list.vx) << kernels->name;
            EXPECT_EQ(of_tile.v[1], of_list.vy) << kernels->name;
            EXPECT_EQ(of_tile.s[0], of_list.s) << kernels->name;
        }
        EXPECT_NE(problem.list().front().r_t, 0);
    }
}

TEST(KernelComparison, HasEveryKernelOnce) {
    test::SceneBuilder builder(0.4);
    builder.box(20, 3.5, {RadiusLaw::Kind::uniform, 0.42, 0.56}).stage(test::solver(0.025, 10));
    test::SerialRun run(builder.scene());
    run.steps(2);
    const auto comparison = compare_kernels(run.simulation(), {3, 1e-4, 1e-4});
    const auto all = kernels_everywhere(Communicator::alone());
    ASSERT_EQ(comparison.kernels.size(), all.size() + 1);
    ASSERT_NE(comparison.find(reference_name), nullptr);
    EXPECT_EQ(comparison.find(reference_name)->times_reference.median, 1);
    for (const auto* kernels : all) {
        ASSERT_NE(comparison.find(kernels->name), nullptr);
        EXPECT_GT(comparison.find(kernels->name)->ns.low, 0);
    }
    EXPECT_EQ(comparison.fastest().over_fastest.median, 1);
    EXPECT_GT(comparison.fill, 0.1);
    EXPECT_LE(comparison.fill, 1);
}

TEST(Triad, ComputesWhatItSays) {
    struct alignas(64) Numbers {
        double value[40];
    } a{}, b{}, c{};
    for (int i = 0; i < 40; ++i) {
        b.value[i] = i;
        c.value[i] = 100 * i;
    }
    bench_loops().triad(a.value, b.value, c.value, 2, 39);
    for (int i = 0; i < 39; ++i) {
        EXPECT_EQ(a.value[i], 201.0 * i);
    }
    EXPECT_EQ(a.value[39], 0);
}

/// Three arrays of doubles in whole lines of 64 bytes, together no more than asked for.
TEST(Triad, CountsTwentyFourBytesAnElement) {
    static_assert(triad_bytes == 24);
    Triad triad(100'000);
    EXPECT_FALSE(triad.right()) << "before a pass";
    const auto figures = measure_triad(Communicator::alone(), triad, 1e-3);
    EXPECT_TRUE(figures.right);
    EXPECT_LE(figures.bytes, 100'000);
    EXPECT_GT(figures.bytes, 100'000 - 3 * 64);
    EXPECT_GE(figures.samples, 10);
    EXPECT_GE(figures.best, figures.median);
    EXPECT_GT(figures.median, 0);
}

} // namespace
} // namespace nappe
