#include "commands/bench_loops.inl"

namespace nappe {

extern const BenchLoops bench_loops_avx512;
const BenchLoops bench_loops_avx512{"avx512", relax_list, triad};

} // namespace nappe
