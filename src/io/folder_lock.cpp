#include "io/folder_lock.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <optional>
#include <string>
#include <sys/file.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

namespace nappe {

namespace {

std::string this_host() {
    std::array<char, 65> host{};
    ::gethostname(host.data(), host.size() - 1);
    return host.data();
}

/// Whether the open file is still the one of that name: the holder before may have taken it away.
bool is_named(const FileDescriptor& file, const std::filesystem::path& path) {
    struct stat opened {
    }, named{};
    return ::fstat(file.get(), &opened) == 0 && ::stat(path.c_str(), &named) == 0 && opened.st_ino == named.st_ino &&
           opened.st_dev == named.st_dev;
}

std::string holder(const FileDescriptor& file) {
    std::array<char, 200> text{};
    const auto n = ::pread(file.get(), text.data(), text.size() - 1, 0);
    return n > 0 ? std::string(text.data(), static_cast<std::size_t>(n)) : std::string("another process");
}

/// Throws InputError or SystemError.
FileDescriptor locked(const std::filesystem::path& path) {
    for (int attempt = 0;;) {
        FileDescriptor file(path, O_RDWR | O_CREAT);
        if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0) {
            if (errno == EINTR) {
                continue;
            }
            if (errno == EWOULDBLOCK && attempt++ < 20) { // nappe info asks, too, for an instant
                std::this_thread::sleep_for(std::chrono::milliseconds(10));
                continue;
            }
            if (errno == EWOULDBLOCK) {
                throw InputError(
                    fmt::format("{}: must be used by one run at a time, found {} at work in it; wait for it, "
                                "stop it, or choose another --out",
                                path.parent_path().string(), holder(file)));
            }
            return {}; // no locks on this file system
        }
        if (is_named(file, path)) {
            return file;
        }
    }
}

} // namespace

FolderLock::FolderLock(const Communicator& comm, const std::filesystem::path& folder) : path_(folder / ".lock") {
    std::string used, refused;
    if (comm.is_root()) {
        try {
            std::error_code code;
            std::filesystem::create_directories(folder, code);
            if (code) {
                throw SystemError(
                    fmt::format("{}: must be a folder that can be written, found: {}; choose another --out",
                                folder.string(), code.message()));
            }
            file_ = locked(path_);
            locks_ = static_cast<bool>(file_);
            const auto text = fmt::format("process {} on {}", ::getpid(), this_host());
            if (locks_ && (::ftruncate(file_.get(), 0) != 0 || write_all(file_, text) != 0)) {
                // Only who it is would be unknown.
            }
        } catch (const InputError& e) {
            used = e.what();
        } catch (const std::exception& e) {
            refused = e.what();
        }
    }
    comm.throw_together<InputError>(used);
    comm.throw_together<SystemError>(refused);
}

std::string FolderLock::holder_of(const std::filesystem::path& folder) {
    try {
        const FileDescriptor file(folder / ".lock", O_RDONLY); // the folder may be another user's
        return ::flock(file.get(), LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK ? holder(file) : std::string();
    } catch (const SystemError&) {
        return {};
    }
}

FolderLock::~FolderLock() {
    if (file_) {
        ::unlink(path_.c_str()); // while it is held: who opened it meanwhile sees that it is gone
    }
}

namespace {

/// Who was writing NAME.part-HOST-PROCESS.
struct Writer {
    std::string host;
    pid_t process = 0;
};

/// None if it is not the name of a file that nappe was writing (temporary_name): of a user's own, perhaps.
std::optional<Writer> writer_of(const std::string& name) {
    constexpr std::string_view mark = ".part-";
    const auto at = name.rfind(mark);
    for (const auto* beside :
         {".data.", ".metadata."}) { // and a number: Open MPI's own, beside a file that ranks share
        const auto end = name.find(beside, at == std::string::npos ? name.size() : at);
        if (end != std::string::npos) {
            return writer_of(name.substr(0, end));
        }
    }
    const auto dash = name.rfind('-');
    if (at == std::string::npos || dash < at + mark.size()) {
        return std::nullopt;
    }
    const auto kind = std::filesystem::path(name.substr(0, at)).extension();
    const auto kinds = {".hdf", ".json", ".csv", ".xdmf", ".toml"};
    Writer writer{name.substr(at + mark.size(), dash - at - mark.size()), 0};
    const char* const end = name.data() + name.size();
    const auto read = std::from_chars(name.data() + dash + 1, end, writer.process);
    const bool whole = read.ec == std::errc() && read.ptr == end && writer.process > 0;
    return whole && std::find(kinds.begin(), kinds.end(), kind) != kinds.end() ? std::optional(writer) : std::nullopt;
}

} // namespace

void remove_remains(const std::filesystem::path& folder, bool of_the_dead_only) {
    std::error_code ignored;
    std::vector<std::filesystem::path> remains;
    for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
        const auto writer = writer_of(entry.path().filename().string());
        if (!writer || !entry.is_regular_file(ignored)) {
            continue;
        }
        if (of_the_dead_only && (writer->host != this_host() || ::kill(writer->process, 0) == 0 || errno != ESRCH)) {
            continue;
        }
        remains.push_back(entry.path());
    }
    for (const auto& path : remains) {
        std::filesystem::remove(path, ignored);
    }
}

} // namespace nappe
