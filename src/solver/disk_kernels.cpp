#include "solver/disk_batch.hpp"

#include "core/error.hpp"

#include <cstring>
#include <string>

namespace nappe {

extern const DiskKernels disk_kernels_scalar;
extern const DiskKernels disk_kernels_portable;
#ifdef NAPPE_X86
extern const DiskKernels disk_kernels_avx2;
extern const DiskKernels disk_kernels_avx512;
#endif

const DiskKernels& disk_kernels(const char* wanted) {
    const auto asked = [wanted](const DiskKernels& set) {
        return wanted == nullptr || std::strcmp(wanted, set.name) == 0;
    };
#ifdef NAPPE_X86
    if (asked(disk_kernels_avx512) && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl")) {
        return disk_kernels_avx512;
    }
    if (asked(disk_kernels_avx2) && __builtin_cpu_supports("avx2")) {
        return disk_kernels_avx2;
    }
#endif
    if (asked(disk_kernels_portable)) {
        return disk_kernels_portable;
    }
    if (asked(disk_kernels_scalar)) {
        return disk_kernels_scalar;
    }
    throw InputError(std::string("--kernel: must name an instruction set this machine has, found '") + wanted +
                     "'; use scalar, portable, avx2 or avx512, or leave it out for the fastest");
}

} // namespace nappe
