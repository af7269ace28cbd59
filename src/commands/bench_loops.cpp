#include "commands/bench_loops.hpp"

#include "solver/disk_batch.hpp"

#include <cstring>
#include <initializer_list>

namespace nappe {

extern const BenchLoops bench_loops_portable;
#ifdef NAPPE_X86
extern const BenchLoops bench_loops_avx2;
extern const BenchLoops bench_loops_avx512;
#endif

const BenchLoops& bench_loops() {
#ifdef NAPPE_X86
    const char* const fastest = disk_kernels().name;
    for (const BenchLoops* loops : {&bench_loops_avx512, &bench_loops_avx2}) {
        if (std::strcmp(fastest, loops->name) == 0) {
            return *loops;
        }
    }
#endif
    return bench_loops_portable;
}

} // namespace nappe
