#pragma once
// Reads back what hdf5_writer.hpp wrote. Every member is Local: each rank opens the file for itself.

#include "io/hdf5_content.hpp"
#include "io/hdf5_handle.hpp"

#include <cstring>
#include <filesystem>

namespace nappe {

/// An HDF5 file open for reading. HDF5 1.10.8 crashes on some damaged files: verify a checksum before opening one that
/// may have been damaged (io/sample_store.cpp). Members throw Hdf5Failure.
class Hdf5Reader {
public:
    explicit Hdf5Reader(const std::filesystem::path& path);

    /// Whether the file has a dataset or group of this path; the groups above it must be there.
    bool has(const std::string& path) const;
    std::int64_t rows(const std::string& dataset) const;
    /// The same, but refused if the file does not hold a byte for each at least: for whoever makes room on its word.
    std::int64_t stored_rows(const std::string& dataset) const;

    /// Rows [first, first + rows), by rows; the dataset must have T's type and this many columns.
    template <class T>
    std::vector<T> read(const std::string& dataset, std::int64_t first, std::int64_t n_rows, int columns = 1) const {
        const auto bytes = read_bytes(dataset, element_type<T>(), columns, first, n_rows);
        std::vector<T> values(bytes.size() / sizeof(T));
        if (!bytes.empty()) {
            std::memcpy(values.data(), bytes.data(), bytes.size());
        }
        return values;
    }

    /// The whole of a dataset of one column.
    template <class T>
    std::vector<T> read(const std::string& dataset) const {
        return read<T>(dataset, 0, rows(dataset));
    }

    std::vector<std::byte> read_bytes(const std::string& dataset, ElementType type, int columns, std::int64_t first,
                                      std::int64_t n_rows) const;

    std::int64_t integer(const std::string& object, const std::string& attribute) const;
    std::uint64_t bits(const std::string& object, const std::string& attribute) const;
    double number(const std::string& object, const std::string& attribute) const;
    std::string text(const std::string& object, const std::string& attribute) const;

private:
    Hdf5Handle file_;
};

} // namespace nappe
