#pragma once
// Settled samples, kept for the next run: FOLDER/KEY.hdf with the bits, and FOLDER/KEY.json, its manifest, which says
// how long the file is and what its checksum is. A sample can always be made again, so anything doubtful is not used.

#include "core/rows.hpp"
#include "io/row_rules.hpp"
#include "parallel/communicator.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace nappe {

/// All that determines a sample.
struct SampleOrigin {
    std::int64_t physics_revision = 0; ///< counted up with every change of the code that changes a bit of a sample
    std::string made_from;             ///< everything of the scene that the sample depends on, in one canonical text

    /// Names the files. Two origins of one key are still told apart: the text is stored and compared.
    std::uint64_t key() const;
};

/// This rank's part of a sample: the grains of a contiguous block of ids, sorted, and the contacts of which `lo` is one
/// of them, sorted by (lo, hi).
template <int D>
struct StoredSample {
    std::vector<GrainRow<D>> grains;
    std::vector<ContactRow<D>> contacts;
    std::int64_t n_grains = 0;    ///< over all ranks
    std::int64_t n_contacts = 0;  ///< over all ranks
    nlohmann::ordered_json notes; ///< as given to store_sample
};

template <int D>
struct SampleLookup {
    std::optional<StoredSample<D>> sample;
    std::string reason; ///< why there is none, for the log; same on all ranks
};

/// FOLDER/KEY.hdf; the manifest beside it ends in .json.
std::filesystem::path sample_path(const std::filesystem::path& folder, const SampleOrigin& origin);

/// Stores a sample, each rank its rows in any order; makes the folder. Collective over comm. The files are the same on
/// any number of ranks. notes: whatever later runs want to report about how it was made.
/// Throws SystemError on all ranks; a sample of that name that was there is then still whole, or not used.
template <int D>
void store_sample(const Communicator& comm, const std::filesystem::path& folder, const SampleOrigin& origin,
                  std::vector<GrainRow<D>> grains, std::vector<ContactRow<D>> contacts,
                  const nlohmann::ordered_json& notes);

/// The sample of this origin, bit for bit as it was stored, or why there is none: no file, no manifest, a file that is
/// damaged or of something else, rows that no computation may start from (io/row_rules.hpp). Collective over comm; all
/// ranks get the same answer. Does not throw for what is on disk.
template <int D>
SampleLookup<D> load_sample(const Communicator& comm, const std::filesystem::path& folder, const SampleOrigin& origin,
                            const RowLimits& limits = {});

} // namespace nappe
