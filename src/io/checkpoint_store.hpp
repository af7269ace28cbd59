#pragma once
// Checkpoints of a run: DIR/checkpoints/checkpoint-NNNNNN.hdf with the bits, and the .json beside it, its manifest
// (io/stored_manifest.hpp). NNNNNN counts up; the newest that is sound is the one to go on from.

#include "core/snapshot.hpp"
#include "parallel/communicator.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace nappe {

template <int D>
struct Checkpoint {
    std::int64_t serial = 0;
    std::uint64_t key = 0;  ///< of what a restart can not change in the scene (commands/restart_rules.hpp)
    std::int64_t ranks = 0; ///< that wrote it
    std::string scene;      ///< the scene as run, as TOML
    Snapshot<D> snapshot;
    nlohmann::ordered_json course; ///< what the program remembers beside the simulation; the root's is stored
    nlohmann::ordered_json notes;  ///< for whoever reads the manifest; likewise
};

/// FOLDER/checkpoint-NNNNNN.hdf.
std::filesystem::path checkpoint_path(const std::filesystem::path& folder, std::int64_t serial);

/// Local. Serials of the manifests in a folder, ascending; none if there is no such folder.
std::vector<std::int64_t> checkpoint_serials(const std::filesystem::path& folder);

/// Local. Takes a checkpoint away, its manifest first.
void remove_checkpoint(const std::filesystem::path& folder, std::int64_t serial);

/// Local. Takes away files of checkpoints that have no manifest: of runs that died between the two.
void remove_orphans(const std::filesystem::path& folder);

/// **Collective.** Writes a checkpoint, complete and verified before its manifest is there; makes the folder. Throws
/// SystemError on all ranks, and nothing is left of it then.
template <int D>
void store_checkpoint(const Communicator& comm, const std::filesystem::path& folder, Checkpoint<D> checkpoint);

template <int D>
struct CheckpointLookup {
    std::optional<Checkpoint<D>> checkpoint; ///< grains of this rank's block of ids
    std::vector<std::string> reasons;        ///< why newer ones are not used; the same on all ranks
    /// Why the newest one that may be sound can not be used here and now: going on from one before it would end in its loss.
    std::string blocked;
};

/// **Collective.** The newest checkpoint that is whole and of this format. One that can not be read now, or is of another
/// revision of the physics, is no reason to go back behind it: `blocked`.
template <int D>
CheckpointLookup<D> load_newest_checkpoint(const Communicator& comm, const std::filesystem::path& folder);

} // namespace nappe
