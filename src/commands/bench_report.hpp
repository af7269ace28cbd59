#pragma once
// The figures of `nappe bench` as tables.

#include "commands/bench_kernels.hpp"
#include "commands/bench_pairs.hpp"
#include "commands/bench_steps.hpp"
#include "commands/bench_table.hpp"
#include "commands/bench_triad.hpp"

#include <vector>

namespace nappe {

/// Bytes of memory traffic that a relaxation is charged with, bodies apart: a contact of 56 bytes read, its two impulses
/// written back. Fixed by what the mechanics needs, not by what the code moves: a fatter contact is our loss, not a higher
/// roof.
inline constexpr double bytes_per_contact_relaxed = 72;

/// A grain's BodyVelocity read and written once in the sweep of its tile.
inline constexpr double bytes_per_grain_swept = 64;

/// All that is measured at one size.
struct SizeFigures {
    std::int64_t grains = 0, contacts = 0; ///< of all ranks
    TriadFigures triad;                    ///< at the bytes that a sweep is charged with
    KernelComparison kernels;
    StepFigures at_100, at_10; ///< by sweeps per step
    Quartiles rebuild_ns;
    MemoryFigures memory;

    double bytes_per_relaxation() const {
        return bytes_per_contact_relaxed +
               bytes_per_grain_swept * static_cast<double>(grains) / static_cast<double>(contacts);
    }
    double roof_ns() const { return bytes_per_relaxation() / triad.best; } ///< per relaxation and rank
};

BenchTable bandwidth_table(const std::vector<SizeFigures>& sizes);
BenchTable kernel_table(const std::vector<SizeFigures>& sizes);
BenchTable step_table(const std::vector<SizeFigures>& sizes);
BenchTable exchange_table(const std::vector<SizeFigures>& sizes); ///< for several ranks
BenchTable memory_table(const std::vector<SizeFigures>& sizes);
BenchTable pair_table(const std::vector<PairFigures>& pairs);

/// The figures that the project asks of itself, as far as this run has them, met or not (bench_asked.cpp).
BenchTable asked_table(const std::vector<SizeFigures>& sizes, int ranks);

} // namespace nappe
