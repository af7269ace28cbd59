#include "io/hdf5_writer.hpp"

#include "core/error.hpp"
#include "io/atomic_file.hpp"
#include "io/hdf5_handle.hpp"
#include "io/hdf5_slab.hpp"
#include "io/hdf5_structure.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <fcntl.h>

namespace nappe {

namespace {

/// Runs one stage of the protocol on this rank; what went wrong, or nothing.
template <class Stage>
std::string error_of(Stage&& stage) {
    try {
        stage();
        return {};
    } catch (const std::exception& failure) {
        return failure.what()[0] ? failure.what() : "unknown failure";
    }
}

/// Collective: no rank goes on before the file is gone.
void remove_together(const Communicator& comm, const std::filesystem::path& path) {
    if (comm.is_root()) {
        std::error_code ignored;
        std::filesystem::remove(path, ignored);
    }
    comm.barrier();
}

/// Rank 0 makes the file with everything but the rows; the error that all ranks agree on. Collective.
std::string prepare(const Communicator& comm, const std::string& path, const Hdf5Content& content) {
    std::string error;
    if (comm.is_root()) {
        error = error_of([&] { create_hdf5_structure(path, content); });
    }
    error = comm.first_error(error);
    if (!error.empty()) {
        return error;
    }
    // A rank that does not see the file would fail alone inside MPI-IO, and the others would wait for it.
    error = error_of([&] { const FileDescriptor seen(path, O_RDWR); });
    if (!error.empty()) {
        error = comm.is_root() ? fmt::format("the file was taken away as soon as it was created ({}); nothing else may "
                                             "move or remove what is in a run's folder",
                                             error)
                               : fmt::format("rank {} does not see a file that rank 0 has created ({}); write to a file "
                                             "system that all nodes share",
                                             comm.rank(), error);
    }
    return comm.first_error(error);
}

Hdf5Handle open_together(const Communicator& comm, const std::string& path) {
    const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "no property list");
    hdf5_check(H5Pset_fapl_mpio(access.get(), comm.handle(), MPI_INFO_NULL), "HDF5 refuses MPI");
    hdf5_check(H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG), "no close degree");
    return Hdf5Handle(H5Fopen(path.c_str(), H5F_ACC_RDWR, access.get()), H5Fclose,
                      "the file can not be opened by all ranks");
}

/// Each rank's rows into the prepared file; the error that all ranks agree on. Collective.
std::string write_rows(const Communicator& comm, const std::string& path, const Hdf5Content& content) {
    Hdf5Handle file;
    std::string error = comm.first_error(error_of([&] { file = open_together(comm, path); }));
    if (!error.empty()) {
        return error;
    }
    error = comm.first_error(error_of([&] {
        for (const auto& dataset : content.datasets) {
            write_slab(file, dataset);
        }
    }));
    // Together, whatever happened above: closing is collective, and leaving it out would hang at the end of the
    // program.
    const std::string at_close = comm.first_error(error_of([&] { file.close("closing the file fails"); }));
    return error.empty() ? at_close : error;
}

/// Local. Throws if this rank's rows are not in the file as they should be.
void verify(const std::string& path, const Hdf5Content& content) {
    const auto file = open_to_read(path);
    for (const auto& dataset : content.datasets) {
        const auto stored =
            read_slab(file, dataset.path, dataset.type, dataset.columns, dataset.range.first, dataset.range.rows);
        if (stored != dataset.bytes) {
            throw Hdf5Failure("dataset " + dataset.path + " reads back different from what was written");
        }
    }
}

} // namespace

void write_hdf5(const Communicator& comm, const std::filesystem::path& path, const Hdf5Content& content) {
    silence_hdf5();
    std::string temporary = temporary_name(path).string();
    comm.broadcast(temporary);
    std::string error = prepare(comm, temporary, content);
    if (error.empty()) {
        error = write_rows(comm, temporary, content);
    }
    if (error.empty()) {
        // By every rank: on a network file system each node keeps its own unwritten pages.
        error = comm.first_error(error_of([&] { sync_file(temporary); }));
    }
    if (error.empty()) {
        error = comm.first_error(error_of([&] { verify(temporary, content); }));
    }
    if (error.empty()) {
        error =
            comm.first_error(comm.is_root() ? error_of([&] { rename_into_place(temporary, path); }) : std::string());
    }
    if (!error.empty()) {
        remove_together(comm, temporary);
        throw SystemError(
            fmt::format("{} is not written: {}. Check the room on that disk, your quota and the limit on the "
                        "size of files (ulimit -f), or write elsewhere",
                        path.string(), error));
    }
}

} // namespace nappe
