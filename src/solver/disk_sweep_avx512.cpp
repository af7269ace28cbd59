#include "solver/disk_sweep.inl"

namespace nappe {

extern const DiskKernels disk_kernels_avx512;
const DiskKernels disk_kernels_avx512{"avx512", relax, apply, refresh, gaps};

} // namespace nappe
