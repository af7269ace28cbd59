// Scenes without friction: a kernel without a tangential part gives what friction 0 gives, to the bit, and leaves spins
// alone.

#include "support/kernels.hpp"
#include "support/serial_run.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <random>

namespace nappe {
namespace {

using test::SceneBuilder;

template <class T>
bool same_bytes(const std::vector<T>& one, const std::vector<T>& other) {
    return one.size() == other.size() && std::memcmp(one.data(), other.data(), one.size() * sizeof(T)) == 0;
}

/// Batches over a few bodies, so that what one batch does the next ones feel; the last body moves not.
struct Problem {
    Problem() {
        std::mt19937_64 random(11);
        std::uniform_real_distribution<double> number(-1, 1);
        for (std::size_t k = 0; k < 40; ++k) {
            u.push_back({{number(random), number(random)}, {number(random)}, 1.5 + number(random)});
        }
        u.back() = {};
        std::vector<std::uint32_t> bodies(u.size() - 1);
        std::iota(bodies.begin(), bodies.end(), 0);
        for (std::size_t k = 0; k < batches.size(); ++k) {
            std::shuffle(bodies.begin(), bodies.end(), random);
            for (std::size_t l = 0; l < n_lanes; ++l) {
                auto& batch = batches[k];
                const std::uint32_t a = bodies[2 * l],
                                    b = l == 3 ? static_cast<std::uint32_t>(u.size() - 1) : bodies[2 * l + 1];
                const double angle = 3 * number(random);
                batch.nx[l] = std::cos(angle);
                batch.ny[l] = std::sin(angle);
                batch.bias[l] = l % 3 == 0 ? 0.2 * (1 + number(random)) : 0.0;
                batch.r_n[l] = l % 2 == 0 ? 1 + number(random) : 0.0;
                batch.a[l] = 4 * a;
                batch.b[l] = 4 * b;
                batch.m_eff[l] = 1 / (u[a].inv_m + u[b].inv_m);
                cohesion[k].most[l] = l % 4 == 1 ? 0.3 : 0.0;
            }
        }
    }

    BatchSpan span(bool friction, bool mixed, bool cohesive) {
        return {batches.data(),
                static_cast<std::int64_t>(batches.size()),
                friction ? tangent.data() : nullptr,
                mixed ? mu.data() : nullptr,
                cohesive ? cohesion.data() : nullptr,
                0.0};
    }

    std::vector<DiskBatch> batches = std::vector<DiskBatch>(6);
    std::vector<TangentBatch> tangent = std::vector<TangentBatch>(batches.size());
    std::vector<FrictionBatch> mu = std::vector<FrictionBatch>(batches.size()); ///< all 0
    std::vector<CohesionBatch> cohesion = std::vector<CohesionBatch>(batches.size());
    std::vector<BodyVelocity<2>> u;
};

TEST(Frictionless, KernelGivesTheBitsOfFrictionNought) {
    for (const char* name : test::kernels_here()) {
        const auto& kernels = disk_kernels(name);
        for (const bool mixed : {false, true}) {
            for (const bool cohesive : {false, true}) {
                Problem without, with;
                const auto u_before = without.u;
                auto plain = without.span(false, false, cohesive), nought = with.span(true, mixed, cohesive);
                kernels.apply(plain, without.u.data()->v.data());
                kernels.apply(nought, with.u.data()->v.data());
                for (int sweep = 0; sweep < 10; ++sweep) {
                    kernels.relax(plain, without.u.data()->v.data(), {});
                    kernels.relax(nought, with.u.data()->v.data(), {});
                }
                EXPECT_TRUE(same_bytes(without.batches, with.batches)) << name << mixed << cohesive;
                EXPECT_TRUE(same_bytes(without.u, with.u)) << name << mixed << cohesive;
                EXPECT_NE(without.batches[2].r_n[0], Problem().batches[2].r_n[0]) << "nothing happened";
                for (std::size_t i = 0; i < u_before.size(); ++i) {
                    EXPECT_EQ(without.u[i].s[0], u_before[i].s[0]) << name << ": spins are not the kernel's";
                }
            }
        }
    }
}

/// The same scene with one more material, which nobody is made of and which rubs: the frictional kernel, friction 0 in
/// each contact.
TEST(Frictionless, WholeRunsGiveTheHashOfFrictionNought) {
    const auto run_of = [](bool spare, double gamma, SolverSettings::Method method) {
        SceneBuilder scene(0);
        scene.box(5, 4, {RadiusLaw::Kind::uniform, 0.13, 0.26}).grain(0.2, {2, 5}, {0, -1}, 3);
        auto settings = test::solver(0.01, 20);
        settings.method = method;
        scene.cohesion(0, 0, gamma, 0.01).stage(settings);
        scene.scene().walls[1].motion = Motion<2>{{0.3, 0}, 0, 0, {}};
        if (spare) {
            const int rubber = scene.material("rubber");
            scene.law(0, rubber, 0.5);
        }
        test::SerialRun run(scene.scene());
        run.steps(120, true);
        EXPECT_EQ(run.state().carries.friction, spare);
        const auto rows = run.simulation().grain_rows();
        EXPECT_TRUE(std::all_of(rows.begin(), rows.end(), [](const auto& row) {
            return (row.spin[0] == 0) == (row.rotation[0] == 0) &&
                   (row.spin[0] == 0 || std::abs(row.spin[0] - 3) < 1e-12);
        })) << "spins stay as given";
        EXPECT_EQ(std::count_if(rows.begin(), rows.end(), [](const auto& row) { return row.spin[0] != 0; }), 1);
        const auto contacts = run.loaded_contacts();
        EXPECT_GT(contacts.size(), 100u);
        EXPECT_TRUE(std::all_of(contacts.begin(), contacts.end(), [](const auto& c) { return c.r_t[0] == 0; }));
        return std::pair(run.simulation().state_hash(), run.simulation().last_residual()->largest);
    };
    using enum SolverSettings::Method;
    // Not cpg: where pressure is only coming it may look along a tangent, whatever the friction will be.
    for (const auto method : {nsgs, ansgs, nncg, apgd}) {
        const int name = static_cast<int>(method);
        EXPECT_EQ(run_of(false, 0, method), run_of(true, 0, method)) << name;
        EXPECT_EQ(run_of(false, 1e3, method), run_of(true, 1e3, method)) << name;
        EXPECT_NE(run_of(false, 0, method), run_of(false, 1e3, method)) << name;
    }
}

} // namespace
} // namespace nappe
