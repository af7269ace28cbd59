#define NAPPE_SCALAR
#include "solver/disk_methods.inl"
#include "solver/disk_sweep.inl"

namespace nappe {

extern const DiskKernels disk_kernels_scalar;
const DiskKernels disk_kernels_scalar{"scalar", relax,    relax_ahead, relax_along, project, gradient,
                                      turn,     go_along, apply,       refresh,     gaps};

} // namespace nappe
