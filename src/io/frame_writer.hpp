#pragma once
// One moment of a run as one HDF5 file, valid VTKHDF too (docs/output.md lists every dataset).

#include "core/rows.hpp"
#include "io/id_blocks.hpp"
#include "parallel/communicator.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace nappe {

/// A wall where it is now.
template <int D>
struct FrameWall {
    std::string name;
    std::vector<Vec<D>> points; ///< [m]
};

/// What a frame shows: this rank's rows, in any order.
template <int D>
struct Frame {
    std::int64_t step = 0;
    double time = 0; ///< [s]
    std::string scene_title;
    std::vector<FrameGrain<D>> grains;     ///< ids 0 … n-1 over all ranks
    std::vector<FrameContact<D>> contacts; ///< each on one rank, any that holds it
    std::vector<FrameWall<D>> walls;       ///< same on all ranks, in the order of Scene::walls
    bool with_bonds = false;               ///< a scene with cohesion: contacts show how they are bonded
};

/// A frame in the order of its file: ids cut into one block a rank.
template <int D>
struct FrameBlock {
    std::int64_t step = 0;
    double time = 0; ///< [s]
    std::string scene_title;
    IdBlocks blocks;
    std::vector<FrameGrain<D>> grains;     ///< of this rank's block, by id
    std::vector<FrameContact<D>> contacts; ///< whose `lo` is in this rank's block, by (lo, hi)
    std::vector<FrameWall<D>> walls;       ///< same on all ranks, in the order of Scene::walls
    bool with_bonds = false;               ///< see Frame
};

/// Local. Positions of grains, contacts and walls are moved by `by` [m]: between those of a scene, relative to its origin,
/// and those of files. Nought changes no bit.
template <int D>
void shift(FrameBlock<D>& frame, const Vec<D>& by);

/// How many rows a frame has over all ranks; the XDMF index needs them.
struct FrameCounts {
    std::int64_t n_grains = 0;
    std::int64_t n_contacts = 0;
};

/// "frames/frame-00000250.hdf", relative to the folder of the run.
std::filesystem::path frame_name(std::int64_t step);

/// The datasets of walls under /walls, in the order of Scene::walls: their names, without what HDF5 would take for a
/// path, and no name twice.
std::vector<std::string> wall_links(const std::vector<std::string>& names);

/// Collective over comm. Every grain and contact to the rank of its block. Throws SystemError on all ranks if one is
/// missing or there twice.
template <int D>
FrameBlock<D> in_blocks(const Communicator& comm, Frame<D>&& frame);

/// Writes a frame; the folder must exist. Collective over comm.
///
/// Rows go to the file sorted by GlobalId, contacts by (lo, hi): every dataset but `rank` is the same on any number of
/// ranks. The file gets its name when it is complete and verified (io/hdf5_writer.hpp). Throws SystemError on all
/// ranks.
template <int D>
FrameCounts write_frame(const Communicator& comm, const std::filesystem::path& path, const FrameBlock<D>& frame);

/// Both in one. Collective over comm.
template <int D>
FrameCounts write_frame(const Communicator& comm, const std::filesystem::path& path, Frame<D>&& frame);

} // namespace nappe
