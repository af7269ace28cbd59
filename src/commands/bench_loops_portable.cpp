#include "commands/bench_loops.inl"

namespace nappe {

extern const BenchLoops bench_loops_portable;
const BenchLoops bench_loops_portable{"portable", relax_list, triad};

} // namespace nappe
