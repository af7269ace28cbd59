#include "commands/bench_triad.hpp"

#include "commands/bench_loops.hpp"
#include "commands/bench_statistics.hpp"

#include <algorithm>

namespace nappe {

Triad::Triad(std::int64_t bytes) {
    const auto n_lines = static_cast<std::size_t>(std::max<std::int64_t>(1, bytes / (3 * sizeof(Line))));
    const auto filled = [n_lines](double value) {
        Line line;
        line.value.fill(value);
        return std::vector<Line>(n_lines, line);
    };
    a_ = filled(0);
    b_ = filled(b_value);
    c_ = filled(c_value);
}

void Triad::pass(int times) {
    const auto n = static_cast<std::int64_t>(8 * a_.size());
    for (int k = 0; k < times; ++k) {
        bench_loops().triad(a_.front().value.data(), b_.front().value.data(), c_.front().value.data(), s, n);
    }
}

std::int64_t Triad::bytes() const {
    return triad_bytes * static_cast<std::int64_t>(8 * a_.size());
}

bool Triad::right() const {
    return std::all_of(a_.begin(), a_.end(), [](const Line& line) {
        return std::all_of(line.value.begin(), line.value.end(), [](double x) { return x == b_value + s * c_value; });
    });
}

TriadFigures measure_triad(const Communicator& comm, Triad& triad, double seconds) {
    constexpr std::size_t least_samples = 10;
    constexpr double least_time = 1e-3; // s a timing: the clock's own time must not show
    const auto timed = [&](int passes) {
        comm.barrier();
        return comm.max(seconds_of([&] { triad.pass(passes); }));
    };
    timed(1);
    const int passes = static_cast<int>(std::clamp(least_time / std::max(timed(1), 1e-9), 1.0, 1e6));
    std::vector<double> rates;
    for (double spent = 0; spent < seconds || rates.size() < least_samples;) {
        const double t = timed(passes);
        spent += t;
        rates.push_back(1e-9 * static_cast<double>(triad.bytes() * passes) / t);
    }
    TriadFigures figures;
    figures.bytes = comm.max(triad.bytes());
    figures.best = *std::max_element(rates.begin(), rates.end());
    figures.median = quartiles(rates).median;
    figures.samples = static_cast<int>(rates.size());
    figures.right = comm.bit_or(triad.right() ? 0u : 1u) == 0;
    return figures;
}

} // namespace nappe
