// Where dropped grains come to lie. On several ranks each has a part of the sample.
#include "commands/drop.hpp"
#include "core/error.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace nappe::drop_test {
namespace {

/// Disks of radius 1 side by side at y = 0, spread over the ranks; a slope to the right of them.
std::vector<GrainRow<2>> bed(const Communicator& comm) {
    std::vector<GrainRow<2>> rows;
    for (GlobalId id = 0; id < 11; ++id) {
        if (id % comm.size() == comm.rank()) {
            GrainRow<2> row;
            row.id = id;
            row.x = {2.0 * static_cast<double>(id), id == 10 ? 3.0 : 0.0};
            row.radius = 1;
            row.mass = 1;
            rows.push_back(row);
        }
    }
    return rows;
}

Scene<2> scene_with(std::vector<SingleGrain<2>> grains, const Vec<2>& gravity = {0, -9.81}) {
    Scene<2> scene;
    scene.gravity = gravity;
    scene.materials.push_back({"rock", 2});
    scene.grains = std::move(grains);
    return scene;
}

SingleGrain<2> dropped(const Vec<2>& position, double radius) {
    SingleGrain<2> grain;
    grain.position = position;
    grain.radius = radius;
    grain.velocity = {0.5, -7};
    grain.drop = true;
    return grain;
}

/// The root's rows beyond the bed.
std::vector<GrainRow<2>> come_down(const Communicator& comm, const Scene<2>& scene) {
    const auto before = bed(comm);
    const auto after = with_dropped(comm, scene, before);
    EXPECT_EQ(after.size() - before.size(),
              comm.is_root() ? std::count_if(scene.grains.begin(), scene.grains.end(), [](auto& g) { return g.drop; })
                             : 0);
    return {after.begin() + static_cast<std::ptrdiff_t>(before.size()), after.end()};
}

TEST(Drop, TouchesTheHighestBelow) {
    const Communicator comm(MPI_COMM_WORLD);
    auto standing = dropped({0, 0}, 1);
    standing.drop = false;
    // Between two disks of radius 1 that touch, one of radius 3 lies sqrt(4² - 1) above their centres; the next lies on it,
    // straight above; the third passes the end one, which is 3 higher, by a hair.
    const auto rows =
        come_down(comm, scene_with({standing, dropped({5, 50}, 3), dropped({5, 60}, 2), dropped({18, 9}, 1)}));
    if (comm.is_root()) {
        ASSERT_EQ(rows.size(), 3u);
        EXPECT_NEAR(rows[0].x[1], std::sqrt(15.0), 1e-12);
        EXPECT_NEAR(rows[1].x[1], std::sqrt(15.0) + 5, 1e-12);
        EXPECT_NEAR(rows[2].x[1], 2.0, 1e-12) << "straight above the ninth";
        for (std::size_t k = 0; k < rows.size(); ++k) {
            EXPECT_EQ(rows[k].id, 11 + static_cast<GlobalId>(k));
            EXPECT_EQ(rows[k].v, (std::array<double, 2>{0.5, -7}));
            EXPECT_EQ(rows[k].x[0], k == 2 ? 18.0 : 5.0);
        }
        EXPECT_NEAR(rows[0].mass, 2 * std::numbers::pi * 9, 1e-12);
    }
}

TEST(Drop, GoesAlongGravityWhereverItPoints) {
    const Communicator comm(MPI_COMM_WORLD);
    const auto rows = come_down(comm, scene_with({dropped({-30, 0.5}, 2)}, {3, 0}));
    if (comm.is_root()) {
        EXPECT_NEAR(rows[0].x[0], -std::sqrt(9 - 0.25), 1e-12);
        EXPECT_EQ(rows[0].x[1], 0.5);
    }
}

TEST(Drop, IsRefusedWhereThereIsNothingBelowOrNoRoom) {
    const Communicator comm(MPI_COMM_WORLD);
    const auto refusal = [&](const SingleGrain<2>& grain) {
        try {
            with_dropped(comm, scene_with({grain}), bed(comm));
        } catch (const InputError& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_NE(refusal(dropped({60, 5}, 1))
                  .find("grains.0.drop: the way along gravity from its position must lead to a "
                        "grain, found none below from [60, 5]"),
              std::string::npos);
    EXPECT_NE(refusal(dropped({4, 0.5}, 1)).find("found it inside of one"), std::string::npos);
    EXPECT_NE(refusal(dropped({4, -5}, 1)).find("found none below"), std::string::npos);
}

} // namespace
} // namespace nappe::drop_test
