#include "commands/bench_loops.inl"

namespace nappe {

extern const BenchLoops bench_loops_avx2;
const BenchLoops bench_loops_avx2{"avx2", relax_list, triad};

} // namespace nappe
