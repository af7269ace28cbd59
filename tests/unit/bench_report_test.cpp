// Sizes, statistics and tables of nappe bench.

#include "commands/bench.hpp"
#include "commands/bench_machine.hpp"
#include "commands/bench_report.hpp"

#include <gtest/gtest.h>

namespace nappe {
namespace {

TEST(BenchSizes, AreReadInOrder) {
    EXPECT_EQ(parse_sizes("3000"), (std::vector<std::int64_t>{3000}));
    EXPECT_EQ(parse_sizes("43000,3000,2700000"), (std::vector<std::int64_t>{43000, 3000, 2700000}));
}

TEST(BenchSizes, BadOnesSayTheRuleAndWhatWasFound) {
    for (const std::string bad : {"0", "-3000", "many", "2999", "100000001", "3e3", "", "99999999999999999999"}) {
        try {
            parse_sizes("5000," + bad);
            ADD_FAILURE() << "took '" << bad << "'";
        } catch (const InputError& e) {
            const std::string text = e.what();
            EXPECT_NE(text.find("--grains: must be whole numbers from 3000"), std::string::npos) << text;
            EXPECT_NE(text.find("found '" + bad + "'"), std::string::npos) << text;
        }
    }
}

TEST(BenchStatistics, QuartilesInterpolate) {
    const auto five = quartiles({5, 1, 4, 2, 3});
    EXPECT_EQ(five.low, 2);
    EXPECT_EQ(five.median, 3);
    EXPECT_EQ(five.high, 4);
    const auto two = quartiles({2, 1});
    EXPECT_EQ(two.low, 1.25);
    EXPECT_EQ(two.median, 1.5);
    EXPECT_EQ(two.high, 1.75);
    EXPECT_EQ(quartiles({}).median, 0);
}

/// Half of all rounds ten times slower, for both: the ratio does not see it.
TEST(BenchStatistics, RatiosAreRoundByRound) {
    const auto r = quartiles(ratios({2, 20, 2, 20}, {1, 10, 1, 10}));
    EXPECT_EQ(r.low, 2);
    EXPECT_EQ(r.high, 2);
}

TEST(BenchTable, IsTextAndJson) {
    BenchTable table("k", "Caption.", {{"name", "name"}, {"n", "count"}, {"x_ms", "ms", 2}, {"met", "met"}});
    EXPECT_TRUE(table.empty());
    table.add({"a", 12, 1.005e3, true});
    table.add({"longer", 3, nullptr, false});
    EXPECT_EQ(table.text(), "Caption.\n"
                            "  name     count        ms   met\n"
                            "  a           12   1005.00   yes\n"
                            "  longer       3         -    no\n\n");
    const auto json = table.json();
    ASSERT_EQ(json.size(), 2u);
    EXPECT_EQ(json[0]["n"], 12);
    EXPECT_EQ(json[0]["x_ms"], 1005.0);
    EXPECT_TRUE(json[1]["x_ms"].is_null());
    EXPECT_EQ(json[1]["met"], false);
}

TEST(BenchMemory, ReadsTheStatusFile) {
    const auto set = parse_resident_set("Name:\tnappe\nVmHWM:\t    2000 kB\nVmRSS:\t    1500 kB\nThreads:\t1\n");
    EXPECT_EQ(set.now, 1500 * 1024);
    EXPECT_EQ(set.highest, 2000 * 1024);
    EXPECT_EQ(parse_resident_set("Name: x\n").now, 0);
    const std::vector<char> touched(50'000'000, 1);
    const auto now = resident_set();
    EXPECT_GT(now.now, 50'000'000) << touched.back();
    EXPECT_GE(now.highest, now.now);
}

TEST(BenchMachine, FindsTheModel) {
    EXPECT_EQ(processor_model("processor\t: 0\nmodel name\t: A Processor 3\nstepping\t: 2\n"), "A Processor 3");
    EXPECT_EQ(processor_model("Features : fp\n"), "");
}

/// 72 B and, with two contacts a grain, half of 64 B; at 26 GB/s that is 4 ns.
TEST(BenchReport, RoofIsBytesOverBandwidth) {
    SizeFigures size;
    size.grains = 1000;
    size.contacts = 2000;
    size.kernels.triad.best = 26;
    EXPECT_EQ(size.bytes_per_relaxation(), 104);
    EXPECT_EQ(size.roof_ns(), 4);
}

/// 43,000 grains at 5 ns under a roof of 4, five times faster than the list; the sweep is 85 % of a step.
SizeFigures fold_figures() {
    SizeFigures size;
    size.grains = 43000;
    size.contacts = 86000;
    size.kernels.triad.best = 26;
    size.kernels.kernels = {{reference_name, 1, {25, 25, 25}, {1, 1, 1}, {5, 5, 5}, {6, 6, 6}},
                            {"avx512", 1, {5, 5, 5}, {5, 5, 5}, {1, 1, 1}, {1, 1, 1}}};
    size.at_100.step_ms = 50;
    size.at_100.other_share = 0.15;
    size.rebuild_ns.median = 200;
    return size;
}

TEST(BenchReport, AskedFiguresAreMetOrNot) {
    const auto met = [](const BenchTable& table, const std::string& figure) {
        for (const auto& row : table.json()) {
            if (row["figure"].get<std::string>().find(figure) != std::string::npos) {
                return row["met"].get<bool>() ? "yes" : "no";
            }
        }
        return "not there";
    };
    const auto fold = fold_figures();
    auto large = fold;
    large.grains = 2'700'000;
    large.contacts = 2 * large.grains;
    large.kernels.triad.best = 13;               // half the bandwidth allows twice the time
    large.kernels.kernels.back().ns.median = 16; // 3.2 times, and 3.2 / 2 is over 1.5
    large.memory.budget = 1e9;
    large.memory.steady = 900'000'000;
    const auto table = asked_table({fold, large}, 1);
    EXPECT_STREQ(met(table, "avx512 over the roof"), "yes"); // 1.25
    EXPECT_STREQ(met(table, "avx512, times faster"), "yes"); // 5
    EXPECT_STREQ(met(table, "avx2"), "not there");
    EXPECT_STREQ(met(table, "100-sweep step outside"), "no"); // 15 %
    EXPECT_STREQ(met(table, "51 ns"), "yes");                 // 10.2
    EXPECT_STREQ(met(table, "over the triad's ratio"), "no");
    EXPECT_STREQ(met(table, "rebuild per grain"), "yes");
    EXPECT_STREQ(met(table, "memory over the budget"), "yes");
    EXPECT_STREQ(met(asked_table({fold}, 2), "imbalance"), "yes");
    EXPECT_STREQ(met(asked_table({fold}, 2), "over the roof"), "not there");
    EXPECT_TRUE(asked_table({}, 1).empty());
}

} // namespace
} // namespace nappe
