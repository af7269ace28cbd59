#pragma once
// One process at a time in a folder, by a lock of the kernel: it ends with the process, however that ends.

#include "io/atomic_file.hpp"
#include "parallel/communicator.hpp"

#include <filesystem>

namespace nappe {

/// Held by rank 0 for the whole job, on FOLDER/.lock, which says who it is.
class FolderLock {
public:
    /// **Collective.** Makes the folder. Throws on all ranks InputError if another process holds it, SystemError if the
    /// folder can not be written. Where the file system knows no locks, there is none: `held`.
    FolderLock(const Communicator& comm, const std::filesystem::path& folder);
    ~FolderLock();
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

    /// On rank 0. False: this file system has no locks, and two runs in one folder would not be told from one.
    bool held() const { return locks_; }
    /// Local. Who holds the folder now, as they say it; empty: nobody, or it can not be told.
    static std::string holder_of(const std::filesystem::path& folder);

private:
    std::filesystem::path path_;
    FileDescriptor file_; ///< on rank 0
    bool locks_ = false;
};

/// Local. Takes away what processes that died left half-written in a folder (atomic_file.hpp, temporary_name): all of it,
/// or only that of dead processes of this machine, where others may be writing too.
void remove_remains(const std::filesystem::path& folder, bool of_the_dead_only);

} // namespace nappe
