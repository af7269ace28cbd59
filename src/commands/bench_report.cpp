#include "commands/bench_report.hpp"

#include <algorithm>

namespace nappe {

namespace {

double megabytes(double bytes) {
    return 1e-6 * bytes;
}

} // namespace

BenchTable bandwidth_table(const std::vector<SizeFigures>& sizes) {
    BenchTable table(
        "bandwidth",
        "Bandwidth and roofline. Triad a[i] = b[i] + s c[i] in double precision, 24 B an element, all ranks "
        "at once, arrays of the size of what a sweep moves:\n72 B a contact and 64 B a grain. Roof: the bytes "
        "of a relaxation over the best triad. Fill: contacts over slots of batches.",
        {{"grains", "grains"},
         {"contacts", "contacts"},
         {"triad_megabytes", "triad MB", 2},
         {"triad_best_gb_per_s", "best GB/s", 1},
         {"triad_median_gb_per_s", "median GB/s", 1},
         {"bytes_per_relaxation", "B/relaxation", 1},
         {"roof_ns", "roof ns", 2},
         {"batch_fill", "fill", 3}});
    for (const auto& s : sizes) {
        table.add({s.grains, s.contacts, megabytes(static_cast<double>(s.kernels.triad.bytes)), s.kernels.triad.best,
                   s.kernels.triad.median, s.bytes_per_relaxation(), s.roof_ns(), s.kernels.fill});
    }
    return table;
}

BenchTable kernel_table(const std::vector<SizeFigures>& sizes) {
    BenchTable table(
        "kernels",
        "Kernels: ns per relaxation and rank (contacts, never padding), median and quartiles of rounds in which "
        "all and the triad take turns. List order: the scalar\nreference, a struct a contact, contacts by "
        "(lo id, hi id), bodies by id. Over roof: with the best triad; other ratios are medians round by round.",
        {{"grains", "grains"},
         {"kernel", "kernel"},
         {"ns", "ns", 2},
         {"ns_low", "25 %", 2},
         {"ns_high", "75 %", 2},
         {"times_reference", "x list order", 2},
         {"over_fastest", "over fastest", 2},
         {"over_roof", "over roof", 2},
         {"over_triad", "over triad", 2},
         {"sweeps_per_round", "sweeps/round"}});
    for (const auto& s : sizes) {
        for (const auto& k : s.kernels.kernels) {
            table.add({s.grains, k.name, k.ns.median, k.ns.low, k.ns.high, k.times_reference.median,
                       k.over_fastest.median, k.ns.median / s.roof_ns(), k.over_triad.median, k.sweeps});
        }
    }
    return table;
}

BenchTable step_table(const std::vector<SizeFigures>& sizes) {
    const auto each = [&](auto&& f) {
        for (const auto& s : sizes) {
            f(s, s.at_100);
            f(s, s.at_10);
        }
    };
    std::array<bool, n_timed> used{};
    each([&](const SizeFigures&, const StepFigures& step) {
        for (std::size_t k = 0; k < n_timed; ++k) {
            used[k] = used[k] || step.ms[k] > 0;
        }
    });
    std::vector<BenchTable::Column> columns = {
        {"grains", "grains"}, {"sweeps", "sweeps"}, {"steps", "steps"}, {"step_ms", "step ms", 2}};
    for (std::size_t k = 0; k < n_timed; ++k) {
        if (used[k]) {
            columns.push_back({std::string(timed_names[k]) + "_ms", timed_names[k], 3});
        }
    }
    columns.insert(columns.end(), {{"other_percent", "other %", 1}, {"rebuilds", "rebuilds"}, {"redone", "redone"}});
    BenchTable table(
        "steps",
        "Steps of the settled pile: ms by stage, mean of steps and ranks; sweep without the exchange inside "
        "it. Other: all but sweeps and exchange.",
        std::move(columns));
    each([&](const SizeFigures& s, const StepFigures& step) {
        BenchTable::Row row = {s.grains, step.sweeps, step.steps, step.step_ms};
        for (std::size_t k = 0; k < n_timed; ++k) {
            if (used[k]) {
                row.push_back(step.ms[k]);
            }
        }
        row.insert(row.end(), {100 * step.other_share, step.rebuilds, step.redone});
        table.add(std::move(row));
    });
    return table;
}

BenchTable exchange_table(const std::vector<SizeFigures>& sizes) {
    BenchTable table(
        "exchange",
        "Exchange at 100 sweeps a step: packing and exposed waiting as a share of the sweep, and how uneven "
        "relaxations are over ranks (largest / mean - 1).",
        {{"grains", "grains"}, {"exchange_percent", "exchange %", 2}, {"imbalance_percent", "imbalance %", 2}});
    for (const auto& s : sizes) {
        table.add({s.grains, 100 * s.at_100.exchange_share, 100 * s.at_100.imbalance});
    }
    return table;
}

BenchTable memory_table(const std::vector<SizeFigures>& sizes) {
    BenchTable table(
        "memory",
        "Rebuild of all lists, ns per grain and rank; and memory: what the resident set of all ranks grew by "
        "for this sample, between steps and at most\n(loading included). Budget: 250 B a grain and 120 B a "
        "contact. Small samples show the allocator more than themselves.",
        {{"grains", "grains"},
         {"rebuild_ns_per_grain", "rebuild ns", 1},
         {"rebuild_ns_low", "25 %", 1},
         {"rebuild_ns_high", "75 %", 1},
         {"before_megabytes", "before MB", 1},
         {"steady_megabytes", "steady MB", 1},
         {"highest_megabytes", "most MB", 1},
         {"bytes_per_grain", "B/grain", 0},
         {"budget_bytes_per_grain", "budget B", 0},
         {"over_budget", "over budget", 2}});
    for (const auto& s : sizes) {
        const auto& m = s.memory;
        const auto n = static_cast<double>(s.grains);
        const auto grown = static_cast<double>(m.steady - m.before);
        table.add({s.grains, s.rebuild_ns.median, s.rebuild_ns.low, s.rebuild_ns.high,
                   megabytes(static_cast<double>(m.before)), megabytes(static_cast<double>(m.steady)),
                   megabytes(static_cast<double>(m.highest)), grown / n, m.budget / n, grown / m.budget});
    }
    return table;
}

BenchTable pair_table(const std::vector<PairFigures>& pairs) {
    BenchTable table(
        "pairs",
        "One rank against all, in alternating turns: ns per relaxation of the sweeps, exchange included, and "
        "how many times faster all ranks are\n(median and quartiles of pairs). Same: both ended in the same "
        "state, bit for bit.",
        {{"grains", "grains"},
         {"contacts", "contacts"},
         {"pairs", "pairs"},
         {"steps", "steps"},
         {"one_ns", "one rank ns", 2},
         {"all_ns", "all ranks ns", 2},
         {"speedup", "x faster", 3},
         {"speedup_low", "25 %", 3},
         {"speedup_high", "75 %", 3},
         {"same_state", "same"}});
    for (const auto& p : pairs) {
        table.add({p.grains, p.contacts, p.pairs, p.steps, p.one_ns.median, p.all_ns.median, p.speedup.median,
                   p.speedup.low, p.speedup.high, p.same_state});
    }
    return table;
}

BenchTable feature_table(const std::vector<FeatureFigures>& features) {
    BenchTable table(
        "features",
        "What a feature adds to the settled pile at 100 sweeps a step, in alternating turns: bytes of a grain and of a "
        "contact; ns per relaxation without it,\nhow many more and how many times as much with it; the same of a "
        "step's rest, all but "
        "the sweeps, per contact (medians, and quartiles of the turns' ratios).\nfriction and spin: added to a pile "
        "without friction; all others to one with one friction coefficient.",
        {{"grains", "grains"},
         {"feature", "feature"},
         {"kernel", "kernel"},
         {"grain_bytes", "B/grain"},
         {"contact_bytes", "B/contact"},
         {"relaxation_ns", "relax ns", 2},
         {"relaxation_added_ns", "more", 2},
         {"relaxation_ratio", "x", 3},
         {"relaxation_ratio_low", "25 %", 3},
         {"relaxation_ratio_high", "75 %", 3},
         {"rest_ns", "rest ns", 1},
         {"rest_added_ns", "more", 1},
         {"rest_ratio", "x", 3},
         {"rest_ratio_low", "25 %", 3},
         {"rest_ratio_high", "75 %", 3}});
    for (const auto& f : features) {
        const auto &relax = f.relaxation, &rest = f.rest;
        table.add({f.grains, f.feature, f.kernel, f.grain_bytes, f.contact_bytes, relax.without.median, relax.added(),
                   relax.ratio.median, relax.ratio.low, relax.ratio.high, rest.without.median, rest.added(),
                   rest.ratio.median, rest.ratio.low, rest.ratio.high});
    }
    return table;
}

} // namespace nappe
