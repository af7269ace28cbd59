// Which pairs are bonded, and what the packing of a step makes of it.

#include "disk_fixture.hpp"

#include <gtest/gtest.h>

namespace nappe {
namespace {

using namespace test;

/// Bonds: within d_w a pair acts however wide its gap is, and when it is parted no pull is handed on, whether its batch
/// stays or is packed anew.
TEST(DiskContacts, WhatIsBondedActsAndWhatIsPartedLosesItsPull) {
    for (const bool anew : {false, true}) {
        Fixture f({0.1, 0.3, -0.01}, {0, 0, 0});
        f.scene.laws[0].gamma = 1e3;
        f.scene.laws[0].d_w = 0.2;
        DiskContacts contacts(f.scene, disk_kernels("portable"));
        contacts.set_cohesive(true);
        contacts.find_bonds(f.state, f.candidates, f.walls);
        for (std::size_t c = 0; c < f.candidates.r_n.size(); ++c) {
            const auto lo = f.state.id[f.candidates.a[c]];
            EXPECT_EQ(f.candidates.bond[c], lo == 1 ? Bond::cohesive : lo == 5 ? Bond::stick : Bond::none) << lo;
            f.candidates.set_impulse(c, {-1e3 * h, {0.1}});
        }
        contacts.pack(f.state, f.candidates, f.walls, h, false);
        auto found = f.packed(contacts);
        ASSERT_TRUE(found.count(1)) << "a gap of 0.1 r at rest would sleep without its bond";
        EXPECT_FALSE(found.count(3)) << "beyond d_w";
        EXPECT_EQ(found.at(1).r_n, -1e3 * h) << "what it had";

        f.candidates.bond.assign(f.candidates.bond.size(), Bond::none);
        if (anew) {
            contacts.store(f.candidates);
            contacts.forget();
        }
        for (LocalId i = 1; i < f.state.n_held(); ++i) { // approaching, so that all stay packed
            f.state.u[i].v[0] = f.state.u_old[i].v[0] = i % 2 == 1 ? 100 : 0;
        }
        contacts.pack(f.state, f.candidates, f.walls, h, false);
        found = f.packed(contacts);
        for (const GlobalId lo : {1, 5}) {
            EXPECT_EQ(found.at(lo).r_n, 0) << lo;
            EXPECT_EQ(found.at(lo).r_t, 0) << lo;
        }
    }
}

} // namespace
} // namespace nappe
