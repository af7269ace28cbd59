#pragma once
// Parallel HDF5 files that are complete, verified and durable before they get their name, or not there at all.

#include "io/hdf5_content.hpp"

#include <filesystem>

namespace nappe {

/// Writes a file, every rank its own rows. Collective over comm.
///
/// Rank 0 lays out the file under a temporary name in the same folder and reserves its room; all open it, each writes
/// its rows independently (collective writes lose data silently when the disk is full, docs/output.md), makes them
/// durable, reads them back and compares; then rank 0 renames. Throws the same SystemError on all ranks if anything
/// failed on any: no temporary file is left then, and an older file of that name is untouched.
void write_hdf5(const Communicator& comm, const std::filesystem::path& path, const Hdf5Content& content);

} // namespace nappe
