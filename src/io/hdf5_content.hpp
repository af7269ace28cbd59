#pragma once
// A whole HDF5 file as a value: its attributes, and for each dataset the rows that this rank contributes. Writers of
// frames and samples fill one; hdf5_writer.hpp stores it. Everything here is Local.

#include "io/id_blocks.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

namespace nappe {

enum class ElementType { float64, int64, int32, uint64, uint8 };

template <class T>
constexpr ElementType element_type() {
    static_assert(std::is_same_v<T, double> || std::is_same_v<T, std::int64_t> || std::is_same_v<T, std::int32_t> ||
                  std::is_same_v<T, std::uint64_t> || std::is_same_v<T, std::uint8_t>);
    if constexpr (std::is_same_v<T, double>) {
        return ElementType::float64;
    } else if constexpr (std::is_same_v<T, std::int64_t>) {
        return ElementType::int64;
    } else if constexpr (std::is_same_v<T, std::int32_t>) {
        return ElementType::int32;
    } else if constexpr (std::is_same_v<T, std::uint64_t>) {
        return ElementType::uint64;
    } else {
        return ElementType::uint8;
    }
}

constexpr std::size_t element_bytes(ElementType type) {
    return type == ElementType::uint8 ? 1 : type == ElementType::int32 ? 4 : 8;
}

/// An image in the plane is stored as a thin slab of two equal layers: ParaView 5.11 writes past the end of a buffer
/// when it opens an image of one.
inline constexpr int image_layers = 2;

/// total x columns elements, of which this rank holds a run of rows; one column makes a dataset of one dimension.
struct Hdf5Dataset {
    std::string path; ///< from the root, "/grains/id"; its groups are made with it
    ElementType type = ElementType::float64;
    int columns = 1;
    RowRange range;
    std::vector<std::byte> bytes; ///< range.rows x columns elements, by rows
    /// Of an image in the plane: a row is a row of so many nodes. The dataset then has the dimensions that VTKHDF
    /// wants, image_layers x total x width, and columns / width components as a fourth if that is not one; `bytes` hold
    /// the rows of one layer after the other. 0: a table.
    int image_width = 0;

    int n_layers() const { return image_width > 0 ? image_layers : 1; }
    std::size_t row_bytes() const { return element_bytes(type) * static_cast<std::size_t>(columns); }
};

/// Same on all ranks.
struct Hdf5Attribute {
    std::string object; ///< a group or dataset; "/" is the file
    std::string name;
    std::variant<std::int64_t, std::uint64_t, double, std::string, std::vector<std::int64_t>, std::vector<double>>
        value;
};

struct Hdf5Content {
    std::vector<std::string> groups; ///< those that would not come with a dataset
    std::vector<Hdf5Dataset> datasets;
    std::vector<Hdf5Attribute> attributes;

    /// A dataset with one row per element of `rows`: fill(row, T* out) writes the row's `columns` elements.
    template <class T, class Rows, class Fill>
    void add(std::string path, int columns, const RowRange& range, const Rows& rows, Fill fill) {
        std::vector<T> values(rows.size() * static_cast<std::size_t>(columns));
        T* out = values.data();
        for (const auto& row : rows) {
            fill(row, out);
            out += columns;
        }
        const auto bytes = std::as_bytes(std::span(values));
        datasets.push_back({std::move(path), element_type<T>(), columns, range, {bytes.begin(), bytes.end()}});
    }

    /// A dataset of one column: get(row) is the element.
    template <class T, class Rows, class Get>
    void add(std::string path, const RowRange& range, const Rows& rows, Get get) {
        add<T>(std::move(path), 1, range, rows, [&](const auto& row, T* out) { *out = get(row); });
    }
};

} // namespace nappe
