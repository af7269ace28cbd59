#pragma once
// Runs of rows to and from the datasets of an open file, in pieces small enough for every MPI-IO. Local: each rank on
// its own.

#include "io/hdf5_content.hpp"
#include "io/hdf5_handle.hpp"

namespace nappe {

/// The hid_t of an element in memory and in the file: the bits are stored as they are.
Hdf5Handle::Id native_type(ElementType type);

/// Writes this rank's rows, independently of the other ranks, into a dataset that is there. Throws Hdf5Failure.
void write_slab(const Hdf5Handle& file, const Hdf5Dataset& rows);

/// Rows [first, first + rows) of a dataset that must have this element type and number of columns; of
/// an image one layer after the other. Throws Hdf5Failure.
std::vector<std::byte> read_slab(const Hdf5Handle& file, const std::string& path, ElementType type, int columns,
                                 std::int64_t first, std::int64_t rows);

/// Opens for reading through the system's calls alone: needs no other rank, takes no lock. Throws Hdf5Failure.
Hdf5Handle open_to_read(const std::string& path);

/// Bytes of the file that a dataset takes. Throws Hdf5Failure.
std::uint64_t stored_bytes(const Hdf5Handle& file, const std::string& path);

/// Number of rows of a dataset. Throws Hdf5Failure.
std::int64_t dataset_rows(const Hdf5Handle& file, const std::string& path);

} // namespace nappe
