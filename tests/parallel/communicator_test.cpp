// What the rest of the program takes for granted of a Communicator.
#include "parallel/communicator.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <thread>

namespace nappe {
namespace {

/// A message whose length and content name sender and receiver; some are empty.
std::vector<std::int64_t> letter(int from, int to) {
    std::vector<std::int64_t> values(static_cast<std::size_t>((3 * from + 5 * to) % 4) * 1000);
    for (std::size_t k = 0; k < values.size(); ++k) {
        values[k] = 1'000'000 * from + 10'000 * to + static_cast<std::int64_t>(k);
    }
    return values;
}

TEST(Communicator, ExchangeBringsEveryLetterToItsReceiver) {
    const Communicator world;
    for (int round = 0; round < 3; ++round) {
        std::vector<std::vector<std::int64_t>> to;
        for (int r = 0; r < world.size(); ++r) {
            to.push_back(letter(world.rank(), r));
        }
        const auto from = world.exchange(to);
        ASSERT_EQ(from.size(), static_cast<std::size_t>(world.size()));
        for (int r = 0; r < world.size(); ++r) {
            EXPECT_EQ(from[static_cast<std::size_t>(r)], letter(r, world.rank())) << "from rank " << r;
        }
    }
}

TEST(Communicator, ExchangeOfNothing) {
    const Communicator world;
    const std::vector<std::vector<double>> nothing(static_cast<std::size_t>(world.size()));
    EXPECT_EQ(world.exchange(nothing), nothing);
}

TEST(Communicator, AllGatherKeepsTheOrderOfRanks) {
    const Communicator world;
    // Rank r has r elements: rank 0 none.
    const std::vector<std::int64_t> mine(static_cast<std::size_t>(world.rank()), 10 + world.rank());
    std::vector<std::int64_t> wanted;
    for (int r = 0; r < world.size(); ++r) {
        wanted.insert(wanted.end(), static_cast<std::size_t>(r), 10 + r);
    }
    EXPECT_EQ(world.all_gather(mine), wanted);
    EXPECT_TRUE(world.all_gather(std::vector<std::int64_t>{}).empty());
}

TEST(Communicator, Reductions) {
    const Communicator world;
    const std::int64_t n = world.size(), r = world.rank();
    EXPECT_EQ(world.sum(r + 1), n * (n + 1) / 2);
    EXPECT_EQ(world.max(-r), 0);
    EXPECT_EQ(world.max(static_cast<double>(r) - 0.5), static_cast<double>(n) - 1.5);
    EXPECT_EQ(world.bit_or(1u << r), (1u << n) - 1);
    const std::uint64_t half = std::uint64_t{1} << 63;
    EXPECT_EQ(world.sum_wrapping(half), n % 2 == 0 ? 0 : half);
    std::vector<std::int64_t> values = {r, -r, 1};
    world.sum(std::span(values));
    EXPECT_EQ(values, (std::vector<std::int64_t>{n * (n - 1) / 2, -n * (n - 1) / 2, n}));
    std::vector<double> heights = {static_cast<double>(r), -std::numeric_limits<double>::infinity()};
    world.max(std::span(heights));
    EXPECT_EQ(heights, (std::vector<double>{static_cast<double>(n - 1), -std::numeric_limits<double>::infinity()}));
    world.sum(std::span<std::int64_t>{});
}

TEST(Communicator, BroadcastFromAnyRank) {
    const Communicator world;
    for (int root = 0; root < world.size(); ++root) {
        std::string text = world.rank() == root ? std::string("said by ") + std::to_string(root) : "something longer";
        world.broadcast(text, root);
        EXPECT_EQ(text, "said by " + std::to_string(root));
        std::string nothing = world.rank() == root ? "" : "not empty";
        world.broadcast(nothing, root);
        EXPECT_EQ(nothing, "");
    }
}

TEST(Communicator, NoErrorIsNoThrow) {
    const Communicator world;
    EXPECT_EQ(world.first_error(""), "");
    EXPECT_NO_THROW(world.throw_together<SystemError>(""));
}

TEST(Communicator, AllRanksThrowTheTextOfTheLowestRankThatHasOne) {
    const Communicator world;
    for (int first = 0; first < world.size(); ++first) {
        const std::string mine = world.rank() >= first ? "rank " + std::to_string(world.rank()) + " failed" : "";
        const std::string wanted = "rank " + std::to_string(first) + " failed";
        EXPECT_EQ(world.first_error(mine), wanted);
        std::string text = "nothing";
        try {
            world.throw_together<NumericalFailure>(mine);
        } catch (const NumericalFailure& e) {
            text = e.what();
        }
        EXPECT_EQ(text, wanted);
    }
}

TEST(Communicator, AloneSeesItselfOnly) {
    const Communicator world;
    const auto alone = Communicator::alone();
    EXPECT_EQ(alone.size(), 1);
    EXPECT_TRUE(alone.is_root());
    EXPECT_EQ(alone.sum(world.rank()), world.rank());
}

/// Nobody gets on before the last one is there.
TEST(Communicator, SleepyBarrierWaitsForTheLast) {
    const Communicator world;
    const auto now = [] { return std::chrono::steady_clock::now(); };
    world.barrier();
    const auto start = now();
    const bool late = world.rank() == world.size() - 1;
    if (late) {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    world.sleepy_barrier();
    // The late one may itself have left the first barrier a little before the others.
    EXPECT_GT(std::chrono::duration<double>(now() - start).count(), late ? 0.05 : 0.02);
}

} // namespace
} // namespace nappe
