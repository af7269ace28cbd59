#define NAPPE_SCALAR
#include "solver/disk_methods.inl"

namespace nappe {

extern const DiskKernels disk_kernels_scalar;
const DiskKernels disk_kernels_scalar{"scalar", relax, relax_ahead, relax_along, project,          gradient,      turn,
                                      go_along, apply, refresh,     advance,     begin_correction, relax_watched, gaps};

} // namespace nappe
