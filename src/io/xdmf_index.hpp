#pragma once
// DIR/run.xdmf and DIR/contacts.xdmf: the frames of a run as series in time, for ParaView and for every other reader of
// XDMF. They hold names and sizes only and point at the datasets of the frames.

#include "parallel/communicator.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace nappe {

/// One frame of the index.
struct FrameEntry {
    double time = 0;            ///< [s]
    std::filesystem::path file; ///< relative to the folder of the index
    std::int64_t n_grains = 0;
    std::int64_t n_contacts = 0;
};

/// The index of a folder, rewritten atomically as frames come: complete at any moment of the run, and after a crash.
class XdmfIndex {
public:
    /// Local; writes nothing yet. dimension: of the scene, for the components of spin and of tangential impulse.
    XdmfIndex(std::filesystem::path folder, int dimension);

    /// Goes on with the frames that there were at a checkpoint. Collective over comm; throws as `add` does.
    void resume(const Communicator& comm, std::vector<FrameEntry> entries);

    const std::vector<FrameEntry>& entries() const { return entries_; }

    /// Adds a frame whose file has its final name. Collective over comm: rank 0 writes, and all ranks throw the same
    /// SystemError if it can not.
    void add(const Communicator& comm, const FrameEntry& entry);

private:
    void write(const Communicator& comm) const;

    std::filesystem::path folder_;
    int dimension_;
    std::vector<FrameEntry> entries_;
};

/// The text of run.xdmf: grains as vertices. Local.
std::string grain_index(const std::vector<FrameEntry>& entries, int dimension);

/// The text of contacts.xdmf: contact points as vertices. Frames without contacts are left out, since readers of XDMF
/// refuse grids of no points. Local.
std::string contact_index(const std::vector<FrameEntry>& entries, int dimension);

} // namespace nappe
