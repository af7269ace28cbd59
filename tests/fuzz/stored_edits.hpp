#pragma once
// Stored files that are whole by every checksum and yet not what they should be: datasets of other types, shapes, lengths
// and values, attributes gone or of other types. The edits follow from bytes, which a fuzzer chooses.

#include <cstdint>
#include <filesystem>
#include <span>

namespace nappe::fuzz {

/// Bytes one after the other; 0 when there are no more.
class ByteSource {
public:
    explicit ByteSource(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
    bool empty() const { return at_ >= bytes_.size(); }
    unsigned next() { return empty() ? 0U : bytes_[at_++]; }
    /// 0 … n-1
    std::size_t below(std::size_t n) { return n == 0 ? 0 : next() % n; }
    std::span<const std::uint8_t> rest() const { return bytes_.subspan(at_ < bytes_.size() ? at_ : bytes_.size()); }

private:
    std::span<const std::uint8_t> bytes_;
    std::size_t at_ = 0;
};

/// Applies edits to a closed HDF5 file until the bytes end, at most 8; the checksums of changed datasets become those of
/// what they then hold, unless an edit is just that they do not.
void edit_stored(const std::filesystem::path& path, ByteSource& bytes);

} // namespace nappe::fuzz
