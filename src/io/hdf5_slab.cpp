#include "io/hdf5_slab.hpp"

#include <hdf5.h>

#include <algorithm>
#include <vector>

namespace nappe {

namespace {

/// MPI-IO counts bytes in an int.
constexpr std::size_t most_bytes_at_once = std::size_t{1} << 28;

/// Sizes along each dimension, and which of them counts rows: the first, but the second of an image (hdf5_content.hpp).
struct Extent {
    std::vector<hsize_t> size;
    std::size_t row = 0;

    hsize_t layers() const { return row == 0 ? 1 : size[0]; }
    hsize_t rows() const { return size[row]; }
    hsize_t columns() const {
        hsize_t product = 1;
        for (std::size_t d = row + 1; d < size.size(); ++d) {
            product *= size[d];
        }
        return product;
    }
};

Extent extent(const Hdf5Handle& space, const std::string& path) {
    const int n_dimensions = H5Sget_simple_extent_ndims(space.get());
    if (n_dimensions < 1 || n_dimensions > 4) {
        throw Hdf5Failure("dataset " + path + " is neither a table nor an image");
    }
    Extent extent{std::vector<hsize_t>(static_cast<std::size_t>(n_dimensions)), n_dimensions > 2 ? 1u : 0u};
    H5Sget_simple_extent_dims(space.get(), extent.size.data(), nullptr);
    if (extent.layers() == 0) {
        throw Hdf5Failure("dataset " + path + " is an image without layers");
    }
    return extent;
}

/// Calls io(memory space, file space, byte offset) for piece after piece of rows [first, first + rows), layer by layer.
template <class Io>
void for_each_piece(const Hdf5Handle& file_space, const Extent& extent, std::size_t row_bytes, std::int64_t first,
                    std::int64_t rows, Io io) {
    const auto n_dimensions = static_cast<int>(extent.size.size());
    const auto per_piece = std::max<std::int64_t>(1, static_cast<std::int64_t>(most_bytes_at_once / row_bytes));
    for (hsize_t layer = 0; layer < extent.layers(); ++layer) {
        const auto before = static_cast<std::int64_t>(layer) * rows;
        for (std::int64_t at = 0; at < rows; at += per_piece) {
            std::vector<hsize_t> start(extent.size.size(), 0);
            auto count = extent.size;
            start[0] = layer;
            count[0] = 1;
            start[extent.row] = static_cast<hsize_t>(first + at);
            count[extent.row] = static_cast<hsize_t>(std::min(per_piece, rows - at));
            const Hdf5Handle memory(H5Screate_simple(n_dimensions, count.data(), nullptr), H5Sclose, "no data space");
            hdf5_check(
                H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr),
                "rows beyond the dataset");
            io(memory.get(), file_space.get(), static_cast<std::size_t>(before + at) * row_bytes);
        }
    }
}

Hdf5Handle space_of(const Hdf5Handle& dataset) {
    return Hdf5Handle(H5Dget_space(dataset.get()), H5Sclose, "no data space");
}

Hdf5Handle open_dataset(const Hdf5Handle& file, const std::string& path) {
    return Hdf5Handle(H5Dopen2(file.get(), path.c_str(), H5P_DEFAULT), H5Dclose,
                      "dataset " + path + " can not be opened");
}

} // namespace

Hdf5Handle::Id native_type(ElementType type) {
    switch (type) {
    case ElementType::float64:
        return H5T_NATIVE_DOUBLE;
    case ElementType::int64:
        return H5T_NATIVE_INT64;
    case ElementType::int32:
        return H5T_NATIVE_INT32;
    case ElementType::uint64:
        return H5T_NATIVE_UINT64;
    case ElementType::uint8:
        return H5T_NATIVE_UINT8;
    }
    return -1;
}

void write_slab(const Hdf5Handle& file, const Hdf5Dataset& rows) {
    const auto dataset = open_dataset(file, rows.path);
    const auto type = native_type(rows.type);
    const auto space = space_of(dataset);
    for_each_piece(space, extent(space, rows.path), rows.row_bytes(), rows.range.first, rows.range.rows,
                   [&](hid_t memory, hid_t in_file, std::size_t at) {
                       hdf5_check(H5Dwrite(dataset.get(), type, memory, in_file, H5P_DEFAULT, rows.bytes.data() + at),
                                  "writing " + rows.path + " fails");
                   });
}

std::vector<std::byte> read_slab(const Hdf5Handle& file, const std::string& path, ElementType type, int columns,
                                 std::int64_t first, std::int64_t rows) {
    const auto dataset = open_dataset(file, path);
    const Hdf5Handle stored(H5Dget_type(dataset.get()), H5Tclose, "dataset " + path + " has no type");
    const auto space = space_of(dataset);
    const auto size = extent(space, path);
    if (H5Tequal(stored.get(), native_type(type)) <= 0 || size.columns() != static_cast<hsize_t>(columns) ||
        first < 0 || rows < 0 || static_cast<hsize_t>(rows) > size.rows() ||
        static_cast<hsize_t>(first) > size.rows() - static_cast<hsize_t>(rows)) {
        throw Hdf5Failure("dataset " + path + " has another type or size than expected");
    }
    const auto row_bytes = element_bytes(type) * static_cast<std::size_t>(columns);
    // A dataset may claim more rows than its file has bytes: nothing is allocated on its word. As doubles: no overflow.
    const double claimed =
        static_cast<double>(size.layers()) * static_cast<double>(size.rows()) * static_cast<double>(row_bytes);
    if (claimed > static_cast<double>(H5Dget_storage_size(dataset.get()))) {
        throw Hdf5Failure("dataset " + path + " claims more rows than are stored");
    }
    std::vector<std::byte> bytes(size.layers() * static_cast<std::size_t>(rows) * row_bytes);
    for_each_piece(space, size, row_bytes, first, rows, [&](hid_t memory, hid_t in_file, std::size_t at) {
        hdf5_check(H5Dread(dataset.get(), native_type(type), memory, in_file, H5P_DEFAULT, bytes.data() + at),
                   "reading " + path + " fails");
    });
    return bytes;
}

Hdf5Handle open_to_read(const std::string& path) {
    silence_hdf5();
    const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "no property list");
    // Locks fail on some cluster file systems, and nobody writes a file once it has its final name.
    hdf5_check(H5Pset_file_locking(access.get(), false, true), "file locking can not be set");
    return Hdf5Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose, "the file can not be opened");
}

std::uint64_t stored_bytes(const Hdf5Handle& file, const std::string& path) {
    return H5Dget_storage_size(open_dataset(file, path).get());
}

std::int64_t dataset_rows(const Hdf5Handle& file, const std::string& path) {
    return static_cast<std::int64_t>(extent(space_of(open_dataset(file, path)), path).rows());
}

} // namespace nappe
