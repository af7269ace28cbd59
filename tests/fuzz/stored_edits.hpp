#pragma once
// Stored files that are whole by every checksum and yet not what they should be: datasets of other types, shapes, lengths
// and values, attributes gone or of other types. The edits follow from bytes, which a fuzzer chooses.

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

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

/// A dataset in memory, of any type and shape.
struct Table {
    hid_t type = -1;
    std::vector<hsize_t> size;
    std::vector<std::byte> bytes;
    bool hollow = false;         ///< stored without its bytes: chunks that were never written
    bool wrong_checksum = false; ///< and a checksum of something else

    std::size_t element() const { return H5Tget_size(type); }
    hsize_t elements() const;
    /// Element number `at` becomes `value`, whose type must be that of the elements.
    template <class T>
    void set(std::size_t at, T value) {
        reinterpret_cast<T*>(bytes.data())[at] = value;
    }
};

/// One dataset of a closed HDF5 file, changed, with its checksum put right.
void change_table(const std::filesystem::path& path, const std::string& dataset,
                  const std::function<void(Table&)>& change);

/// Applies edits to a closed HDF5 file until the bytes end, at most 8; the checksums of changed datasets become those of
/// what they then hold, unless an edit is just that they do not.
void edit_stored(const std::filesystem::path& path, ByteSource& bytes);

} // namespace nappe::fuzz
