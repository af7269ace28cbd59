#include "io/checksum.hpp"

#include "core/error.hpp"
#include "io/atomic_file.hpp"
#include "parallel/communicator.hpp"

#include <fmt/format.h>
#include <xxhash.h>

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>
#include <vector>

namespace nappe {

namespace {

/// Fixed, since it is part of what a stored checksum means.
constexpr std::size_t piece_bytes = std::size_t{1} << 20;

/// Fills `buffer` from `offset` on, less at the end of the file; the number of bytes read.
std::size_t read_piece(const FileDescriptor& file, const std::filesystem::path& path, std::span<std::byte> buffer,
                       std::int64_t offset) {
    std::size_t n = 0;
    while (n < buffer.size()) {
        const auto got = ::pread(file.get(), buffer.data() + n, buffer.size() - n, offset + static_cast<off_t>(n));
        if (got < 0 && errno == EINTR) {
            continue;
        }
        if (got < 0) {
            throw SystemError(fmt::format("{}: reading fails: {}", path.string(), std::strerror(errno)));
        }
        if (got == 0) {
            break;
        }
        n += static_cast<std::size_t>(got);
    }
    return n;
}

} // namespace

std::uint64_t checksum(std::string_view bytes) {
    return XXH3_64bits(bytes.data(), bytes.size());
}

std::uint64_t row_checksum(std::span<const std::byte> bytes, std::size_t row_bytes, std::int64_t first_row) {
    std::uint64_t total = 0;
    auto row = static_cast<std::uint64_t>(first_row);
    for (std::size_t at = 0; at < bytes.size(); at += row_bytes) {
        total += XXH3_64bits_withSeed(bytes.data() + at, row_bytes, row++);
    }
    return total;
}

std::uint64_t file_checksum(const Communicator& comm, const std::filesystem::path& path) {
    std::uint64_t total = 0;
    std::string error;
    try {
        const FileDescriptor file(path, O_RDONLY);
        std::vector<std::byte> buffer(piece_bytes);
        for (auto piece = static_cast<std::uint64_t>(comm.rank());; piece += static_cast<std::uint64_t>(comm.size())) {
            const auto n = read_piece(file, path, buffer, static_cast<std::int64_t>(piece * piece_bytes));
            if (n == 0) {
                break;
            }
            total += XXH3_64bits_withSeed(buffer.data(), n, piece);
        }
    } catch (const std::exception& failure) {
        error = failure.what();
    }
    comm.throw_together<SystemError>(error);
    return comm.sum_wrapping(total);
}

} // namespace nappe
