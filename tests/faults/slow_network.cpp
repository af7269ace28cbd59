// Loaded before MPI: each reduction over all ranks takes a millisecond more, as on a slow network, so that a run of some
// hundred steps lasts long enough for its test to do something in the middle, on the fastest machine. Also loaded into
// mpirun, which has no such function, and does not call this one.
#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>
#include <unistd.h>

#pragma weak PMPI_Allreduce

extern "C" int MPI_Allreduce(const void* mine, void* all, int count, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
    usleep(1000);
    return PMPI_Allreduce(mine, all, count, type, op, comm);
}
