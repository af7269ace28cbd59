#define NAPPE_SCALAR
#include "solver/disk_sweep.inl"

namespace nappe {

extern const DiskKernels disk_kernels_scalar;
const DiskKernels disk_kernels_scalar{"scalar", relax, relax_cohesive, apply, refresh, refresh_cohesive, gaps};

} // namespace nappe
