#pragma once
// The figures of `nappe bench` as tables.

#include "commands/bench_features.hpp"
#include "commands/bench_kernels.hpp"
#include "commands/bench_pairs.hpp"
#include "commands/bench_steps.hpp"
#include "commands/bench_table.hpp"

#include <vector>

namespace nappe {

/// All that is measured at one size.
struct SizeFigures {
    std::int64_t grains = 0, contacts = 0; ///< of all ranks
    KernelComparison kernels;
    StepFigures at_100, at_10; ///< by sweeps per step
    Quartiles rebuild_ns;
    MemoryFigures memory;

    double bytes_per_relaxation() const {
        return bytes_per_contact_relaxed +
               bytes_per_grain_swept * static_cast<double>(grains) / static_cast<double>(contacts);
    }
    double roof_ns() const { return bytes_per_relaxation() / kernels.triad.best; } ///< per relaxation and rank
};

BenchTable bandwidth_table(const std::vector<SizeFigures>& sizes);
BenchTable kernel_table(const std::vector<SizeFigures>& sizes);
BenchTable step_table(const std::vector<SizeFigures>& sizes);
BenchTable exchange_table(const std::vector<SizeFigures>& sizes); ///< for several ranks
BenchTable memory_table(const std::vector<SizeFigures>& sizes);
BenchTable pair_table(const std::vector<PairFigures>& pairs);
BenchTable feature_table(const std::vector<FeatureFigures>& features);

/// The figures that the project asks of itself, as far as this run has them, met or not (bench_asked.cpp).
BenchTable asked_table(const std::vector<SizeFigures>& sizes, int ranks);

} // namespace nappe
