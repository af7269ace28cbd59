#include "solver/disk_methods.inl"
#include "solver/disk_single.inl"
#include "solver/disk_smooth.inl"

namespace nappe {

extern const DiskKernels disk_kernels_avx512;
const DiskKernels disk_kernels_avx512{
    "avx512", relax,  relax_ahead, relax_along,  project,          gradient,      turn,
    go_along, apply,  refresh,     advance,      begin_correction, relax_watched, gaps,
    press,    record, open_grains, close_grains, round_batches,    relax_single,  settle_single};

} // namespace nappe
