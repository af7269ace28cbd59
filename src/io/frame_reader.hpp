#pragma once
// Reads back what frame_writer.hpp wrote, bit for bit, on as many ranks as one likes.

#include "io/frame_writer.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace nappe {

/// Reads a frame: each rank the rows of its block of ids. Collective over comm.
///
/// Each rank opens the file for itself. What is read must be a frame of this scene: ids 0 … n-1 in their order, finite
/// positions, velocities and impulses, positive radii and masses, contacts in the order of (lo, hi) between grains of
/// the frame or with walls of the scene. A frame has no checksum: a number that was changed and still makes sense is
/// not found. Throws InputError on all ranks alike, with the rule, the value found and the remedy.
///
/// @param step what the file's name says @param wall_names of Scene::walls
template <int D>
FrameBlock<D> read_frame(const Communicator& comm, const std::filesystem::path& path, std::int64_t step,
                         const std::vector<std::string>& wall_names);

/// The steps of the frames that belong to the run in `folder`, ascending: those that run.xdmf lists, since frames of an
/// older run may lie beside them. Collective over comm. Throws InputError on all ranks.
std::vector<std::int64_t> stored_frames(const Communicator& comm, const std::filesystem::path& folder);

} // namespace nappe
