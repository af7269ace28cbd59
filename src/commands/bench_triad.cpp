#include "commands/bench_triad.hpp"

#include "commands/bench_loops.hpp"
#include "commands/bench_statistics.hpp"

#include <algorithm>
#include <vector>

namespace nappe {

namespace {

struct alignas(64) Line {
    double value[8];
};

/// Pages are touched when it is made. 64-byte boundaries: else every vector load of 512 bits crosses two lines.
struct Array {
    Array(std::int64_t n_lines, double value)
        : lines(static_cast<std::size_t>(n_lines), Line{value, value, value, value, value, value, value, value}) {}
    double* data() { return lines.front().value; }
    std::vector<Line> lines;
};

} // namespace

TriadFigures measure_triad(const Communicator& comm, std::int64_t bytes, double seconds) {
    constexpr int least_samples = 10;
    constexpr double least_time = 1e-3; // s a timing: the clock's own time must not show
    constexpr double s = 3;
    const auto n_lines = std::max<std::int64_t>(1, bytes / (3 * static_cast<std::int64_t>(sizeof(Line))));
    const auto n = 8 * n_lines;
    Array a(n_lines, 0), b(n_lines, 1), c(n_lines, 2);
    const auto& loops = bench_loops();
    const auto timed = [&](int passes) {
        comm.barrier();
        return comm.max(seconds_of([&] {
            for (int k = 0; k < passes; ++k) {
                loops.triad(a.data(), b.data(), c.data(), s, n);
            }
        }));
    };
    timed(1);
    const int passes = static_cast<int>(std::clamp(least_time / std::max(timed(1), 1e-9), 1.0, 1e6));
    std::vector<double> rates;
    for (double spent = 0; spent < seconds || static_cast<int>(rates.size()) < least_samples;) {
        const double t = timed(passes);
        spent += t;
        rates.push_back(1e-9 * static_cast<double>(triad_bytes * n * passes) / t);
    }
    TriadFigures figures;
    figures.bytes = comm.max(triad_bytes * n);
    figures.best = *std::max_element(rates.begin(), rates.end());
    figures.median = quartiles(rates).median;
    figures.samples = static_cast<int>(rates.size());
    figures.right = std::all_of(a.data(), a.data() + n, [](double value) { return value == 1 + s * 2; });
    return figures;
}

} // namespace nappe
