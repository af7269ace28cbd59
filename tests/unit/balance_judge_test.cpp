// When tiles move: worked out by hand.
#include "parallel/balance_judge.hpp"

#include <gtest/gtest.h>

namespace nappe {
namespace {

BalanceSettings settings(double threshold, BalanceSettings::Moves moves = BalanceSettings::Moves::when_it_pays) {
    return {threshold, 100, BalanceSettings::By::work, moves};
}

TEST(BalanceJudge, NothingMovesBelowTheThreshold) {
    BalanceJudge judge(settings(1.05));
    EXPECT_FALSE(judge.wants_cut(1.05, 1000));
    EXPECT_TRUE(judge.wants_cut(1.051, 1000));
}

TEST(BalanceJudge, AMoveMustSaveMoreThanItCosts) {
    BalanceJudge judge(settings(1.0));
    ASSERT_TRUE(judge.wants_cut(1.2, 10)) << "no cost known yet";
    ASSERT_TRUE(judge.accepts(1.1));
    judge.moved(1.0);
    EXPECT_EQ(judge.cost(), 1.0);
    // From 1.2 to the 1.1 within reach, over the seconds ahead: 0.1 x 9 < 1 < 0.1 x 11.
    EXPECT_FALSE(judge.wants_cut(1.2, 9));
    EXPECT_TRUE(judge.wants_cut(1.2, 11));
    // The cut turns out to reach 1.15 only: 0.05 x 11 < 1.
    EXPECT_FALSE(judge.accepts(1.15));
    EXPECT_TRUE(judge.wants_cut(1.2, 25));
    EXPECT_TRUE(judge.accepts(1.15)); // 0.05 x 25 > 1
    judge.moved(3.0);
    EXPECT_EQ(judge.cost(), 2.0) << "the mean of what was foreseen and what it was";
    judge.moved(-1.0); // a rebuild that happened to be quicker than the one before
    EXPECT_EQ(judge.cost(), 1.0);
}

TEST(BalanceJudge, WhereTilesAreTooCoarseItStopsAsking) {
    BalanceJudge judge(settings(1.01));
    ASSERT_TRUE(judge.wants_cut(1.30, 10));
    ASSERT_TRUE(judge.accepts(1.25));
    for (int look = 1; look <= BalanceJudge::memory; ++look) {
        EXPECT_FALSE(judge.wants_cut(1.25, 10)) << "look " << look << ": the last cut reached no better";
    }
    EXPECT_TRUE(judge.wants_cut(1.25, 10)) << "the work may have changed meanwhile";
    EXPECT_FALSE(judge.accepts(1.2499)) << "less than the least gain";
    EXPECT_TRUE(judge.wants_cut(1.28, 10)) << "worse than what the last cut could reach";
}

TEST(BalanceJudge, AlwaysKnowsNoCost) {
    BalanceJudge judge(settings(1.0, BalanceSettings::Moves::always));
    judge.moved(1e6);
    EXPECT_TRUE(judge.wants_cut(1.0001, 0));
    EXPECT_TRUE(judge.accepts(1.5));
    EXPECT_FALSE(judge.wants_cut(1.0, 0));
}

} // namespace
} // namespace nappe
