#include "solver/disk_sweep.inl"

namespace nappe {

extern const DiskKernels disk_kernels_avx2;
const DiskKernels disk_kernels_avx2{"avx2", relax, relax_cohesive, apply, refresh, refresh_cohesive, gaps};

} // namespace nappe
