#pragma once
// Everything of an HDF5 file but the rows of its datasets: groups, attributes, and where each dataset lies. Local: one
// rank makes it.
//
// Why HDF5 does not simply create the file: if the disk fills up while HDF5 1.10.8 writes its own structure, closing
// hangs (several ranks) or the program crashes at its end (one rank). So all room is reserved before HDF5 opens the
// file, and when the structure is there, parallel HDF5 has nothing left to write but rows.

#include "io/hdf5_content.hpp"

#include <filesystem>

namespace nappe {

/// Creates the file in its full length, with all of its room reserved and the structure in it. The same content makes
/// the same bytes. Throws SystemError (no room, no permission) or Hdf5Failure.
void create_hdf5_structure(const std::filesystem::path& path, const Hdf5Content& content);

} // namespace nappe
