#define NAPPE_SCALAR
#include "solver/disk_sweep.inl"

namespace nappe {

extern const DiskKernels disk_kernels_scalar;
const DiskKernels disk_kernels_scalar{"scalar", relax, apply, refresh, gaps};

} // namespace nappe
