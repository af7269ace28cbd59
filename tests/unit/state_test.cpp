// State: what goes in comes out, bit for bit; walls and padding do not move.

#include "core/state.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

namespace nappe {
namespace {

GrainRow<2> some_row(GlobalId id) {
    const auto k = static_cast<double>(id + 1);
    GrainRow<2> row;
    row.id = id;
    row.x = {k / 3, -k / 7};
    row.v = {0.1 * k, -0.2 / k};
    row.spin = {3 * k};
    row.rotation = {-k / 11};
    row.radius = 0.5; // spin = (radius x spin) / radius comes back exactly
    row.mass = 2.5 * k;
    row.cells = (std::uint64_t{1} << 63) | static_cast<std::uint64_t>(id);
    row.material = static_cast<std::int32_t>(id % 3);
    row.layer = static_cast<std::int32_t>(id % 9);
    return row;
}

/// Every member, so that one added later and forgotten in a copy is seen (the byte counts below).
void expect_equal(const GrainRow<2>& a, const GrainRow<2>& b) {
    EXPECT_EQ(a.id, b.id);
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.v, b.v);
    EXPECT_EQ(a.spin, b.spin);
    EXPECT_EQ(a.rotation, b.rotation);
    EXPECT_EQ(a.radius, b.radius);
    EXPECT_EQ(a.mass, b.mass);
    EXPECT_EQ(a.cells, b.cells);
    EXPECT_EQ(a.material, b.material);
    EXPECT_EQ(a.layer, b.layer);
}
static_assert(sizeof(GrainRow<2>) == 8 + 16 + 16 + 8 + 8 + 8 + 8 + 8 + 4 + 4, "a new member: extend expect_equal");

TEST(State, RowsSurviveTheRoundTrip) {
    for (GlobalId id = 0; id < 20; ++id) {
        expect_equal(to_row(to_record(some_row(id))), some_row(id));
    }
    const auto record = to_record(some_row(4));
    EXPECT_EQ(record.u.s[0], 0.5 * 15.0) << "rim speed is radius x spin";
    EXPECT_EQ(record.u.inv_m, 1 / 12.5);
}

TEST(State, RecordsSurviveTheRoundTrip) {
    std::vector<GrainRecord<2>> own, ghosts;
    for (GlobalId id = 0; id < 7; ++id) {
        auto record = to_record(some_row(id));
        record.margin = 0.01 * static_cast<double>(id);
        (id < 4 ? own : ghosts).push_back(record);
    }
    State<2> state;
    state.assign(own, ghosts, 6);
    EXPECT_EQ(state.n_own, 4);
    EXPECT_EQ(state.n_held(), 7);
    EXPECT_EQ(state.n_bodies(), 7 + 6 + 1);
    EXPECT_EQ(state.null_body(), 13);
    for (LocalId i = 0; i < state.n_held(); ++i) {
        const auto& in = i < 4 ? own[static_cast<std::size_t>(i)] : ghosts[static_cast<std::size_t>(i - 4)];
        const auto out = state.record(i);
        expect_equal(to_row(out), to_row(in));
        EXPECT_EQ(out.margin, in.margin);
        EXPECT_EQ(std::memcmp(&out.u, &in.u, sizeof(in.u)), 0);
        EXPECT_EQ(std::memcmp(&state.u_old[i], &in.u, sizeof(in.u)), 0);
        EXPECT_EQ(state.x_ref[i], state.x[i]);
        EXPECT_EQ(state.mid[i].position(), state.x[i]);
        EXPECT_EQ(state.mid[i].radius, state.radius[i]);
    }
    for (LocalId k = state.n_held(); k < state.n_bodies(); ++k) {
        EXPECT_EQ(state.u[k].v[0], 0);
        EXPECT_EQ(state.u[k].v[1], 0);
        EXPECT_EQ(state.u[k].s[0], 0);
        EXPECT_EQ(state.u[k].inv_m, 0) << "walls and padding never move";
    }
}

/// A second assign forgets the first, however much larger that was.
TEST(State, AssignReplaces) {
    State<2> state;
    std::vector<GrainRecord<2>> many(10, to_record(some_row(3)));
    state.assign(many, many, 4);
    state.assign({to_record(some_row(5))}, {}, 2);
    EXPECT_EQ(state.n_held(), 1);
    EXPECT_EQ(state.n_bodies(), 4);
    EXPECT_EQ(state.u[1].inv_m, 0);
    expect_equal(to_row(state.record(0)), some_row(5));
}

/// m v²/2 + I w²/2 with I = m r²/2: the rim speed counts for half of what the centre's does.
TEST(State, KineticEnergyOfADisk) {
    BodyVelocity<2> u;
    u.v = {3, -4};
    u.s = {6};
    EXPECT_DOUBLE_EQ(kinetic_energy(u, 10.0), 0.5 * 10 * (25 + 18));
}

} // namespace
} // namespace nappe
