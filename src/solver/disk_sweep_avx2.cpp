#include "solver/disk_sweep.inl"

namespace nappe {

extern const DiskKernels disk_kernels_avx2;
const DiskKernels disk_kernels_avx2{"avx2", relax, apply, refresh, gaps};

} // namespace nappe
