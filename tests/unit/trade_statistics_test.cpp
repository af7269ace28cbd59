// Scatter, verdict and front of nappe trade, on numbers whose answers are known by hand; and how runs become rows.

#include "commands/trade_report.hpp"
#include "commands/trade_statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace nappe {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Differences 1, 3, 2: mean 2, deviation 1, standard error 1/sqrt(3). The reference 2, 4, 6: mean 4, deviation 2.
TEST(TradeCompare, DifferencesArePairedAndMeasuredByTheScatterOfTheReference) {
    const auto c = compare(std::vector{3.0, 7.0, 8.0}, std::vector{2.0, 4.0, 6.0});
    EXPECT_EQ(c.n, 3u);
    EXPECT_DOUBLE_EQ(c.mean, 6);
    EXPECT_DOUBLE_EQ(c.reference, 4);
    EXPECT_DOUBLE_EQ(c.difference, 2);
    EXPECT_DOUBLE_EQ(c.standard_error, 1 / std::sqrt(3.0));
    EXPECT_DOUBLE_EQ(c.scatter, 2);
    EXPECT_DOUBLE_EQ(c.over_scatter, 1);
    EXPECT_DOUBLE_EQ(c.error_over_scatter, 0.5 / std::sqrt(3.0));
    // 2 / (1/sqrt 3) = 3.46 standard errors; three seeds ask for 4.30.
    EXPECT_EQ(c.verdict, Verdict::within);
}

/// The same differences, six of each kind: 2 +- 0.2, ten times the standard error.
TEST(TradeCompare, MoreSeedsTellASmallDifferenceFromChance) {
    std::vector<double> ours, theirs;
    for (int k = 0; k < 6; ++k) {
        for (const double d : {1.0, 3.0, 2.0}) {
            theirs.push_back(100 * k);
            ours.push_back(100 * k + d);
        }
    }
    const auto c = compare(ours, theirs);
    EXPECT_EQ(c.verdict, Verdict::differs);
    EXPECT_LT(c.over_scatter, 0.02);        // small beside the scatter between seeds, which pairs take out
    std::reverse(ours.begin(), ours.end()); // no longer the same seeds side by side
    EXPECT_EQ(compare(ours, theirs).verdict, Verdict::within);
}

TEST(TradeCompare, OneSeedKnowsNoScatter) {
    const auto c = compare(std::vector{3.0}, std::vector{2.0});
    EXPECT_EQ(c.verdict, Verdict::unknown);
    EXPECT_EQ(c.difference, 1);
    EXPECT_TRUE(std::isnan(c.scatter) && std::isnan(c.standard_error) && std::isnan(c.over_scatter));
}

TEST(TradeCompare, SeedsWithoutBothValuesAreLeftOut) {
    const auto c = compare(std::vector{3.0, nan, 5.0, 9.0}, std::vector{2.0, 4.0, nan, 10.0});
    EXPECT_EQ(c.n, 2u);
    EXPECT_EQ(c.mean, 6);
    EXPECT_EQ(c.reference, 6);
    EXPECT_EQ(c.difference, 0);
    EXPECT_EQ(compare(std::vector{nan, 1.0}, std::vector{1.0, nan}).verdict, Verdict::absent);
}

TEST(TradeCompare, WhatIsRoundedToBinsScattersByTheBin) {
    const std::vector ours{2.0, 2.0, 2.0}, theirs{1.0, 1.0, 1.0};
    EXPECT_EQ(compare(ours, theirs).verdict, Verdict::differs);
    EXPECT_TRUE(std::isnan(compare(ours, theirs).over_scatter));
    EXPECT_EQ(compare(ours, theirs, 0.5).over_scatter, 2);
    EXPECT_EQ(compare(std::vector{1.0, 3.0}, std::vector{0.0, 2.0}, 0.5).over_scatter, 1 / std::sqrt(2.0));
    EXPECT_EQ(compare(theirs, theirs).over_scatter, 0);
    EXPECT_EQ(compare(theirs, theirs).verdict, Verdict::within);
}

/// Against tables of Student's distribution.
TEST(TradeCompare, QuantilesAreStudents) {
    EXPECT_NEAR(student_quantile(1), 12.706, 1e-3);
    EXPECT_NEAR(student_quantile(7), 2.365, 1e-3);
    for (const auto& [n, t] : {std::pair{11u, 2.201}, {15u, 2.131}, {30u, 2.042}, {120u, 1.980}}) {
        EXPECT_NEAR(student_quantile(n), t, 0.001 * t) << n;
    }
}

TEST(TradeCompare, MeanSquaresLeaveOutWhatIsNoNumber) {
    EXPECT_DOUBLE_EQ(root_mean_square(std::vector{3.0, nan, -4.0}), std::sqrt(12.5));
    EXPECT_TRUE(std::isnan(root_mean_square(std::vector{nan})));
}

TEST(TradeFront, KeepsWhatNothingBeatsInBoth) {
    const std::vector<TradePoint> points{{1, 10}, {2, 5}, {3, 6}, {4, 5}, {5, 1}, {2, 5}, {0.5, nan}, {nan, 0}};
    EXPECT_EQ(pareto_front(points), (std::vector{true, true, false, false, true, true, false, false}));
    EXPECT_TRUE(pareto_front({}).empty());
}

TEST(TradeFigures, SeedsBecomeOneColumnByColumn) {
    std::vector<TradeFigures> runs(3);
    runs[0].seconds_steps = 5, runs[1].seconds_steps = 90, runs[2].seconds_steps = 6;
    runs[0].relaxations = 1, runs[1].relaxations = 2, runs[2].relaxations = 6;
    runs[0].overlap_max_of_rows = 0.1, runs[1].overlap_max_of_rows = 0.3, runs[2].overlap_max_of_rows = nan;
    runs[0].weight_on_walls_least = 0.9, runs[1].weight_on_walls_least = 0.3, runs[2].weight_on_walls_least = 1;
    const auto all = over_seeds(runs);
    EXPECT_EQ(all.seconds_steps, 6); // what disturbs one run does not count
    EXPECT_EQ(all.relaxations, 3);
    EXPECT_EQ(all.overlap_max_of_rows, 0.3);
    EXPECT_EQ(all.weight_on_walls_least, 0.3);
    EXPECT_TRUE(std::isnan(over_seeds({}).relaxations));
}

/// A reference and three settings, two seeds.
class TradeTable : public testing::Test {
protected:
    TradeTable() {
        plan_.names = {"reference", "cheap", "good", "broken"};
        plan_.seeds = {1, 2};
        add(0, 1000, 1e-6, 5.0);
        add(1, 10, 1e-2, 5.5);
        add(2, 100, 1e-4, 5.25);
        add(3, 1, 1e-3, 4.0);
    }
    /// The observable differs by 2 between the seeds.
    void add(std::size_t setting, double relaxations, double overlap, double value) {
        for (std::size_t seed = 0; seed < 2; ++seed) {
            RunFigures run;
            run.figures.relaxations = run.figures.seconds_steps = relaxations;
            run.figures.overlap_mean = overlap;
            run.observables = {{"front", "m", value + 2 * static_cast<double>(seed), 0}};
            results_.push_back({setting, seed, run, ""});
        }
    }
    TradePlan plan_;
    std::vector<TradeResult> results_;
};

TEST_F(TradeTable, MarksTheFrontAmongSettings) {
    const auto rows = trade_rows(plan_, results_);
    ASSERT_EQ(rows.size(), 4u);
    EXPECT_FALSE(rows[0].fronts.relaxations_overlap); // the reference is what is compared with
    EXPECT_FALSE(rows[1].fronts.relaxations_overlap); // "broken" is cheaper and better
    EXPECT_TRUE(rows[2].fronts.relaxations_overlap);
    EXPECT_TRUE(rows[3].fronts.relaxations_overlap);
    EXPECT_TRUE(rows[1].fronts.relaxations_observables);
    // The scatter of the reference's 5, 7 is sqrt 2.
    EXPECT_DOUBLE_EQ(rows[1].observable_error, 0.5 / std::sqrt(2.0));
    EXPECT_EQ(rows[1].observables[0].comparison.verdict, Verdict::differs); // by the same in both pairs
}

TEST_F(TradeTable, ASettingAsTightAsTheReferenceIsNamed) {
    EXPECT_TRUE(as_tight_as_reference(trade_rows(plan_, results_)).empty());
    EXPECT_EQ(trade_text(trade_rows(plan_, results_), 2).find("no tighter than"), std::string::npos);
    for (auto& result : results_) {
        result.figures->figures.overlap_mean = result.setting == 2 ? 1e-7 : result.figures->figures.overlap_mean;
    }
    EXPECT_EQ(as_tight_as_reference(trade_rows(plan_, results_)), std::vector<std::string>{"good"});
    EXPECT_NE(trade_text(trade_rows(plan_, results_), 2).find("no tighter than good"), std::string::npos);
}

TEST_F(TradeTable, FailedSettingsSayWhyAndStandOnNoFront) {
    results_.back().figures.reset();
    results_.back().failure = "grain 7 outran its tile, at \"once\"";
    const auto rows = trade_rows(plan_, results_);
    EXPECT_EQ(trade_status(rows[3], 2), "failed (1 of 2): grain 7 outran its tile, at \"once\"");
    EXPECT_FALSE(rows[3].fronts.relaxations_overlap);
    EXPECT_TRUE(rows[1].fronts.relaxations_overlap);
    const auto csv = trade_csv(rows, 2);
    EXPECT_NE(csv.find("\"failed (1 of 2): grain 7 outran its tile, at \"\"once\"\"\"\n"), std::string::npos) << csv;
    EXPECT_NE(trade_text(rows, 2).find("broken: failed (1 of 2)"), std::string::npos);
}

/// Stopped after the first seed, where "broken" had failed with the second already.
TEST_F(TradeTable, FailedSettingsStandOnNoFrontThoughOthersLackTheRunToo) {
    std::erase_if(results_, [](const TradeResult& result) { return result.seed == 1; });
    EXPECT_TRUE(trade_rows(plan_, results_)[3].fronts.relaxations_overlap);
    results_.push_back({3, 1, std::nullopt, "a grain left"});
    const auto rows = trade_rows(plan_, results_);
    EXPECT_FALSE(rows[3].fronts.relaxations_overlap);
    EXPECT_TRUE(rows[1].fronts.relaxations_overlap);
}

TEST_F(TradeTable, AReferenceThatIsARunAheadLeavesTheOthersTheirFront) {
    std::erase_if(results_, [](const TradeResult& result) { return result.seed == 1 && result.setting > 0; });
    EXPECT_TRUE(trade_rows(plan_, results_)[2].fronts.relaxations_overlap);
}

TEST_F(TradeTable, AReferenceThatFailedLeavesTheOthersTheirFront) {
    results_.front().figures.reset();
    results_.front().failure = "a grain left";
    EXPECT_TRUE(trade_rows(plan_, results_)[2].fronts.relaxations_overlap);
}

TEST_F(TradeTable, SettingsThatLackRunsStandOnNoFront) {
    results_.pop_back();
    const auto rows = trade_rows(plan_, results_);
    EXPECT_EQ(trade_status(rows[3], 2), "1 of 2 seeds");
    EXPECT_FALSE(rows[3].fronts.relaxations_overlap);
    EXPECT_EQ(rows[3].observables[0].comparison.verdict, Verdict::unknown);
}

TEST_F(TradeTable, ManyCellsALineAndAsManyHeads) {
    const auto rows = trade_rows(plan_, results_);
    for (const auto& text : {trade_csv(rows, 2), observables_csv(rows)}) {
        std::vector<std::ptrdiff_t> commas;
        for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1) {
            commas.push_back(std::count(text.begin() + static_cast<std::ptrdiff_t>(at),
                                        text.begin() + static_cast<std::ptrdiff_t>(text.find('\n', at)), ','));
        }
        EXPECT_EQ(commas, std::vector<std::ptrdiff_t>(5, commas[0])) << text;
    }
}

} // namespace
} // namespace nappe
