#pragma once
// Files that are either whole or not there: written under another name in the same folder, made durable, then renamed.
// A reader (ParaView while the run goes on, the next run after a crash) never meets half a file. Everything is Local.

#include <filesystem>
#include <string>
#include <string_view>

namespace nappe {

/// An open file; closed with its owner.
class FileDescriptor {
public:
    FileDescriptor() = default;
    /// Throws SystemError with the path and the system's reason. `flags` as of open(2); new files get 0666 & ~umask.
    FileDescriptor(const std::filesystem::path& path, int flags);
    ~FileDescriptor();
    FileDescriptor(FileDescriptor&& other) noexcept;
    FileDescriptor& operator=(FileDescriptor&& other) noexcept;
    FileDescriptor(const FileDescriptor&) = delete;
    FileDescriptor& operator=(const FileDescriptor&) = delete;

    int get() const { return descriptor_; }
    explicit operator bool() const { return descriptor_ >= 0; }

    /// 0, or the errno of close(2): on network file systems that is where a full disk shows.
    int close();

private:
    int descriptor_ = -1;
};

/// Where `path` is written before it is renamed: in the same folder, and not the name any other process would take.
std::filesystem::path temporary_name(const std::filesystem::path& path);

/// Waits until the file's bytes are on the disk. Throws SystemError.
void sync_file(const std::filesystem::path& path);

/// Gives a complete file its final name, replacing an older one, and makes the new name durable. Throws SystemError.
void rename_into_place(const std::filesystem::path& temporary, const std::filesystem::path& path);

/// Writes a small text file atomically. Throws SystemError; then no temporary file is left and an older file of that
/// name is untouched.
void write_file_atomically(const std::filesystem::path& path, std::string_view text);

/// Writes all bytes in spite of interruptions; 0, or the errno.
int write_all(const FileDescriptor& file, std::string_view bytes);

/// "no space left …", and what to do about it: the tail of a message about a failed write.
std::string remedy_for_writing(int error_number);

} // namespace nappe
