#include "solver/disk_sweep.inl"

namespace nappe {

extern const DiskKernels disk_kernels_portable;
const DiskKernels disk_kernels_portable{"portable", relax, apply, refresh, gaps};

} // namespace nappe
