#pragma once
// Checksums of what is stored: XXH3 (Debian's libxxhash), 64 bits. They find damage, not forgery.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

namespace nappe {

class Communicator;

/// Of some bytes. Local.
std::uint64_t checksum(std::string_view bytes);

/// Of a table of rows, as a sum over rows (modulo 2^64) of a checksum seeded with the row's number. So the sum over the
/// slabs of several ranks is that of the whole table, on any number of ranks. Local: sum it with sum_wrapping.
///
/// bytes: this rank's rows; row_bytes: length of one; first_row: number of the first in the whole table.
std::uint64_t row_checksum(std::span<const std::byte> bytes, std::size_t row_bytes, std::int64_t first_row);

/// Of a whole file, its pieces shared out among the ranks; the same number on any of them and on any number of them.
/// Collective over comm. Throws SystemError on all ranks if one can not read.
std::uint64_t file_checksum(const Communicator& comm, const std::filesystem::path& path);

} // namespace nappe
