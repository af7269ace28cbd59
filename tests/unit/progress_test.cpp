// What a user sees: in a log, on a terminal, on a rank that must be silent.
#include "io/progress.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <regex>

namespace nappe {
namespace {

/// A Progress whose clock the test turns, writing into memory.
struct Shown {
    explicit Shown(bool terminal, bool enabled = true) {
        Progress::Settings settings;
        settings.enabled = enabled;
        settings.terminal = terminal;
        settings.out = ::open_memstream(&buffer, &length);
        settings.now = [this] { return clock; };
        out = settings.out;
        progress = std::make_unique<Progress>(settings);
    }
    ~Shown() {
        progress.reset();
        std::fclose(out);
        std::free(buffer);
    }
    Shown(const Shown&) = delete;
    Shown& operator=(const Shown&) = delete;

    std::string text() {
        std::fflush(out);
        return std::string(buffer, length);
    }

    double clock = 1000;
    char* buffer = nullptr;
    std::size_t length = 0;
    std::FILE* out = nullptr;
    std::unique_ptr<Progress> progress;
};

/// So many steps of the given seconds each.
void go(Shown& shown, int n_steps, double seconds) {
    for (int step = 1; step <= n_steps; ++step) {
        shown.clock += seconds;
        shown.progress->update(step, 0.025 * step);
    }
}

auto n_lines(const std::string& text) {
    return std::count(text.begin(), text.end(), '\n');
}

TEST(Progress, LogHasALineNowAndThen) {
    Shown shown(false);
    shown.progress->begin_stage("push", 20000);
    go(shown, 60, 0.5);
    const auto text = shown.text();
    EXPECT_EQ(n_lines(text), 3) << text; // every 10 s at first
    EXPECT_TRUE(
        std::regex_search(text, std::regex(R"(\] push 20/20000 \(0 %\), t = 0\.5 s, 2 steps/s, 2 h 47 min left\n)")))
        << text;
    EXPECT_EQ(text.find('\r'), std::string::npos);
}

TEST(Progress, LogOfADayHasAboutAHundredLines) {
    Shown shown(false);
    shown.progress->begin_stage("push", 86400);
    go(shown, 86400, 1);
    const auto n = n_lines(shown.text());
    EXPECT_GT(n, 80);
    EXPECT_LT(n, 250);
}

TEST(Progress, TerminalRedrawsOneLineAndMessagesDoNotMixWithIt) {
    Shown shown(true);
    shown.progress->begin_stage("settle", 0);
    go(shown, 20, 0.1);
    EXPECT_EQ(n_lines(shown.text()), 0) << shown.text();
    EXPECT_TRUE(shown.text().ends_with("\rsettle 20 steps, t = 0.5 s, 10 steps/s\x1b[K")) << shown.text();
    const auto before = shown.text().size();
    shown.progress->info("frame written");
    const auto after = shown.text().substr(before);
    EXPECT_TRUE(after.starts_with("\r\x1b[K[")) << after;
    EXPECT_NE(after.find("frame written"), std::string::npos);
    EXPECT_EQ(n_lines(after), 1);
}

TEST(Progress, StageEndsWithItsMeanRate) {
    Shown shown(false);
    shown.progress->begin_stage("push", 100);
    go(shown, 100, 0.05);
    shown.progress->end_stage();
    EXPECT_NE(shown.text().find("push 100 steps, t = 2.5 s, 20 steps/s, done in 5 s\n"), std::string::npos)
        << shown.text();
}

TEST(Progress, RateIsOfTheStepsDoneNow) {
    Shown shown(false);
    shown.progress->begin_stage("push", 100, 90); // after a restart
    shown.clock += 2;
    shown.progress->update(100, 2.5);
    shown.progress->end_stage();
    EXPECT_NE(shown.text().find("push 100 steps, t = 2.5 s, 5 steps/s, done in 2 s\n"), std::string::npos)
        << shown.text();
}

TEST(Progress, OtherRanksAreSilent) {
    Shown shown(true, false);
    shown.progress->begin_stage("push", 100);
    go(shown, 100, 10);
    shown.progress->info("nothing");
    shown.progress->warning("nothing");
    shown.progress->end_stage();
    EXPECT_EQ(shown.text(), "");
}

TEST(Progress, Durations) {
    EXPECT_EQ(format_duration(0), "0 s");
    EXPECT_EQ(format_duration(45.4), "45 s");
    EXPECT_EQ(format_duration(12 * 60), "12 min");
    EXPECT_EQ(format_duration(3600), "1 h 0 min");
    EXPECT_EQ(format_duration(12000), "3 h 20 min");
}

} // namespace
} // namespace nappe
