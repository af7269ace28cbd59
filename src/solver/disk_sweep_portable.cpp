#include "solver/disk_sweep.inl"

namespace nappe {

extern const DiskKernels disk_kernels_portable;
const DiskKernels disk_kernels_portable{"portable", relax, relax_cohesive, apply, refresh, refresh_cohesive, gaps};

} // namespace nappe
