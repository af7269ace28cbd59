// What the project asks of itself on one core and on two, from the figures of one run.

#include "commands/bench_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace nappe {

namespace {

// A step of jobs/fold.toml as others take it: the reference code of this field, 43,000 disks, 100 iterations, one core.
constexpr double peer_ns = 51, peer_step_ms = 1130;

/// The size measured within 10 % of `grains`, or nullptr.
const SizeFigures* size_near(const std::vector<SizeFigures>& sizes, double grains) {
    const auto it = std::find_if(sizes.begin(), sizes.end(), [grains](const SizeFigures& s) {
        return std::abs(static_cast<double>(s.grains) - grains) <= 0.1 * grains;
    });
    return it == sizes.end() ? nullptr : &*it;
}

class AskedTable {
public:
    void most(const std::string& figure, double found, double limit) {
        table_.add({figure, found, fmt::format("<= {}", limit), found <= limit});
    }
    void least(const std::string& figure, double found, double limit) {
        table_.add({figure, found, fmt::format(">= {}", limit), found >= limit});
    }
    BenchTable take() { return std::move(table_); }

private:
    BenchTable table_{"asked",
                      "Asked, as far as this run has it. Shares of a step are those of a pile at rest.",
                      {{"figure", "figure"}, {"found", "found", 2}, {"asked", "asked"}, {"met", "met"}}};
};

void ask_of_one_core(AskedTable& table, const SizeFigures& fold) {
    if (const auto* avx512 = fold.kernels.find("avx512")) {
        table.most("43k: avx512 over the roof", avx512->ns.median / fold.roof_ns(), 1.5);
        table.least("43k: avx512, times faster than list order", avx512->times_reference.median, 4);
    }
    if (const auto* avx2 = fold.kernels.find("avx2")) {
        table.least("43k: avx2, times faster than list order", avx2->times_reference.median, 2.5);
    }
    table.least("43k: times less per relaxation than 51 ns", peer_ns / fold.kernels.fastest().ns.median, 10);
    table.least("43k: times less per step of 100 sweeps than 1.13 s", peer_step_ms / fold.at_100.step_ms, 20);
}

void ask_of_growth(AskedTable& table, const SizeFigures& fold, const SizeFigures& large) {
    const double ns = large.kernels.fastest().ns.median / fold.kernels.fastest().ns.median;
    const double triad = fold.kernels.triad.best / large.kernels.triad.best;
    table.most("2.7M over 43k: ns per relaxation, over the triad's ratio", ns / triad, 1.5);
    table.most("2.7M over 43k: rebuild per grain", large.rebuild_ns.median / fold.rebuild_ns.median, 1.3);
}

} // namespace

BenchTable asked_table(const std::vector<SizeFigures>& sizes, int ranks) {
    AskedTable table;
    const auto* fold = size_near(sizes, 43000);
    const auto* small = size_near(sizes, 10000);
    const auto* large = size_near(sizes, 2.7e6);
    if (fold != nullptr) {
        if (ranks == 1) {
            ask_of_one_core(table, *fold);
        }
        table.most("43k: % of a 100-sweep step outside sweeps", 100 * fold->at_100.other_share, 10);
        table.most("43k: % of a 10-sweep step outside sweeps", 100 * fold->at_10.other_share, 35);
    }
    if (ranks == 2) {
        for (const auto& [size, name, limit] : {std::tuple(fold, "43k", 5.0), std::tuple(small, "10k", 10.0)}) {
            if (size != nullptr) {
                table.most(fmt::format("{}: % of a sweep for packing and waiting", name),
                           100 * size->at_100.exchange_share, limit);
            }
        }
        if (fold != nullptr) {
            table.most("43k: % imbalance of relaxations", 100 * fold->at_100.imbalance, 2);
        }
    }
    if (fold != nullptr && large != nullptr) {
        ask_of_growth(table, *fold, *large);
    }
    if (large != nullptr) {
        const auto grown = static_cast<double>(large->memory.steady - large->memory.before);
        table.most("2.7M: memory over the budget", grown / large->memory.budget, 1);
    }
    return table.take();
}

} // namespace nappe
