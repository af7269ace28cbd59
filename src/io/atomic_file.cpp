#include "io/atomic_file.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>
#include <utility>

namespace nappe {

namespace {

[[noreturn]] void fail(const std::filesystem::path& path, std::string_view what, int error_number) {
    throw SystemError(fmt::format("{}: {}: {}", path.string(), what, remedy_for_writing(error_number)));
}

std::filesystem::path folder_of(const std::filesystem::path& path) {
    return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

void write_and_sync(const std::filesystem::path& path, std::string_view text) {
    FileDescriptor file(path, O_WRONLY | O_CREAT | O_TRUNC);
    if (const int error = write_all(file, text)) {
        fail(path, "writing fails", error);
    }
    if (::fsync(file.get()) != 0) {
        fail(path, "writing to the disk fails", errno);
    }
    if (const int error = file.close()) {
        fail(path, "closing fails", error);
    }
}

} // namespace

FileDescriptor::FileDescriptor(const std::filesystem::path& path, int flags)
    : descriptor_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {
    if (descriptor_ < 0) {
        if (flags & O_CREAT) {
            fail(path, "the file can not be created", errno);
        }
        throw SystemError(fmt::format("{}: can not be opened: {}", path.string(), std::strerror(errno)));
    }
}

FileDescriptor::~FileDescriptor() {
    close();
}

FileDescriptor::FileDescriptor(FileDescriptor&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
    if (this != &other) {
        close();
        descriptor_ = std::exchange(other.descriptor_, -1);
    }
    return *this;
}

int FileDescriptor::close() {
    const int descriptor = std::exchange(descriptor_, -1);
    return descriptor < 0 || ::close(descriptor) == 0 ? 0 : errno;
}

std::filesystem::path temporary_name(const std::filesystem::path& path) {
    // Several runs may prepare the same sample in one shared folder at once, from several machines.
    std::array<char, 65> host{};
    ::gethostname(host.data(), host.size() - 1);
    return path.string() + fmt::format(".part-{}-{}", host.data(), ::getpid());
}

void sync_file(const std::filesystem::path& path) {
    FileDescriptor file(path, O_RDWR);
    if (::fsync(file.get()) != 0) {
        fail(path, "writing to the disk fails", errno);
    }
}

void rename_into_place(const std::filesystem::path& temporary, const std::filesystem::path& path) {
    if (std::rename(temporary.c_str(), path.c_str()) != 0) {
        fail(path, "the complete file can not be given its name", errno);
    }
    const auto folder = folder_of(path);
    const FileDescriptor handle(folder, O_RDONLY | O_DIRECTORY);
    // Some network file systems have no fsync of folders (EINVAL); they order names by themselves.
    if (::fsync(handle.get()) != 0 && errno != EINVAL) {
        fail(folder, "writing the folder to the disk fails", errno);
    }
}

void write_file_atomically(const std::filesystem::path& path, std::string_view text) {
    const auto temporary = temporary_name(path);
    try {
        write_and_sync(temporary, text);
        rename_into_place(temporary, path);
    } catch (...) {
        std::error_code ignored;
        std::filesystem::remove(temporary, ignored);
        throw;
    }
}

int write_all(const FileDescriptor& file, std::string_view bytes) {
    while (!bytes.empty()) {
        const auto n = ::write(file.get(), bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n < 0) {
            return errno;
        }
        bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return 0;
}

std::string remedy_for_writing(int error_number) {
    const std::string reason = std::strerror(error_number);
    switch (error_number) {
    case ENOSPC:
    case EDQUOT:
        return reason + "; free some space or quota, or write to another disk";
    case EFBIG:
        return reason + "; raise the limit on the size of files (ulimit -f)";
    case EMFILE:
    case ENFILE:
        return reason + "; raise the limit on open files (ulimit -n)";
    case ENOENT:
    case ENOTDIR:
        return reason + "; create the folder first, on a file system that all nodes share";
    case EACCES:
    case EPERM:
    case EROFS:
        return reason + "; choose a folder you may write to";
    default:
        return reason;
    }
}

} // namespace nappe
