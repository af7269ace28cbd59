#include "fuzz/stored_edits.hpp"

#include "fuzz/fuzz_target.hpp"

#include "io/checksum.hpp"
#include "io/hdf5_handle.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

namespace nappe::fuzz {

namespace {

using Handle = Hdf5Handle;

std::vector<hid_t> types() {
    return {H5T_NATIVE_DOUBLE, H5T_NATIVE_INT64, H5T_NATIVE_INT32, H5T_NATIVE_UINT64, H5T_NATIVE_UINT8,
            H5T_NATIVE_FLOAT,  H5T_IEEE_F64BE,   H5T_STD_I64BE,    H5T_C_S1};
}

herr_t gather(hid_t, const char* name, const H5O_info_t* info, void* paths) {
    if (info->type == H5O_TYPE_DATASET) {
        static_cast<std::vector<std::string>*>(paths)->push_back("/" + std::string(name));
    }
    return 0;
}

std::vector<std::string> datasets_of(const Handle& file) {
    std::vector<std::string> paths;
    H5Ovisit(file.get(), H5_INDEX_NAME, H5_ITER_INC, gather, &paths);
    return paths;
}

Table read_table(const Handle& file, const std::string& path) {
    const Handle dataset(H5Dopen2(file.get(), path.c_str(), H5P_DEFAULT), H5Dclose, path);
    const Handle space(H5Dget_space(dataset.get()), H5Sclose, "space");
    const Handle stored(H5Dget_type(dataset.get()), H5Tclose, "type");
    Table table;
    for (const hid_t type : types()) {
        table.type = H5Tequal(type, stored.get()) > 0 ? type : table.type;
    }
    table.size.resize(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space.get())));
    H5Sget_simple_extent_dims(space.get(), table.size.data(), nullptr);
    constexpr hsize_t most = 1 << 16; // more is claimed only where an edit before made it so
    if (table.type < 0 || H5Dget_storage_size(dataset.get()) > most || table.elements() > most) {
        table.type = -1;
        return table;
    }
    table.bytes.resize(table.elements() * table.element());
    H5Dread(dataset.get(), table.type, H5S_ALL, H5S_ALL, H5P_DEFAULT, table.bytes.data());
    return table;
}

void write_table(const Handle& file, const std::string& path, const Table& table) {
    if (H5Lexists(file.get(), path.c_str(), H5P_DEFAULT) > 0) {
        H5Ldelete(file.get(), path.c_str(), H5P_DEFAULT);
    }
    const Handle space(table.size.empty()
                           ? H5Screate(H5S_SCALAR)
                           : H5Screate_simple(static_cast<int>(table.size.size()), table.size.data(), nullptr),
                       H5Sclose, "space");
    const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "creation");
    if (table.hollow && !table.size.empty()) {
        const std::vector<hsize_t> chunk(table.size.size(), 1);
        H5Pset_chunk(creation.get(), static_cast<int>(chunk.size()), chunk.data());
    }
    const Handle dataset(
        H5Dcreate2(file.get(), path.c_str(), table.type, space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
        H5Dclose, path);
    if (!table.hollow && !table.bytes.empty()) {
        H5Dwrite(dataset.get(), table.type, H5S_ALL, H5S_ALL, H5P_DEFAULT, table.bytes.data());
    }
    // As io/stored_rows.cpp: rows are what the first dimension counts.
    const auto rows = table.size.empty() || table.size[0] == 0 ? hsize_t{1} : table.size[0];
    const auto row_bytes = std::max<std::size_t>(1, table.bytes.size() / rows);
    const std::uint64_t sum = row_checksum(table.bytes, row_bytes, 0) + (table.wrong_checksum ? 1 : 0);
    const Handle scalar(H5Screate(H5S_SCALAR), H5Sclose, "scalar");
    const Handle attribute(
        H5Acreate2(dataset.get(), "checksum", H5T_NATIVE_UINT64, scalar.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
        "checksum");
    H5Awrite(attribute.get(), H5T_NATIVE_UINT64, &sum);
}

/// One element becomes one that no computation can bear.
void set_element(Table& table, ByteSource& bytes) {
    constexpr std::array<double, 10> reals = {std::numeric_limits<double>::quiet_NaN(),
                                              std::numeric_limits<double>::infinity(),
                                              -std::numeric_limits<double>::infinity(),
                                              0.0,
                                              -1.0,
                                              1e300,
                                              -1e300,
                                              4.9e-324,
                                              1e18,
                                              0.5};
    constexpr std::array<std::int64_t, 12> integers = {0,
                                                       -1,
                                                       1,
                                                       2,
                                                       std::numeric_limits<std::int64_t>::max(),
                                                       std::numeric_limits<std::int64_t>::min(),
                                                       std::int64_t{1} << 62,
                                                       (std::int64_t{1} << 62) + 5,
                                                       std::int64_t{1} << 40,
                                                       std::numeric_limits<std::int32_t>::max(),
                                                       100,
                                                       -7};
    const std::size_t element = table.element();
    if (table.bytes.size() < element) {
        return;
    }
    const std::size_t at = bytes.below(table.bytes.size() / element) * element;
    const bool real = H5Tget_class(table.type) == H5T_FLOAT && element == sizeof(double);
    const double number = reals[bytes.below(reals.size())];
    const std::int64_t integer = integers[bytes.below(integers.size())];
    std::memcpy(table.bytes.data() + at, real ? static_cast<const void*>(&number) : static_cast<const void*>(&integer),
                std::min(element, sizeof integer));
}

/// Another number of bytes: the old ones again and again.
void refill(Table& table) {
    const auto old = table.bytes;
    table.bytes.assign(table.elements() * table.element(), std::byte{1});
    for (std::size_t i = 0; i < table.bytes.size() && !old.empty(); ++i) {
        table.bytes[i] = old[i % old.size()];
    }
}

void reshape(Table& table, ByteSource& bytes) {
    switch (bytes.below(7)) {
    case 0: // more rows
        table.size.empty() ? void() : void(table.size[0] += bytes.below(4) + 1);
        break;
    case 1: // fewer
        table.size.empty() ? void() : void(table.size[0] /= bytes.below(4) + 2);
        break;
    case 2: // other columns
        table.size.size() == 2 ? void(table.size[1] = bytes.below(4)) : table.size.push_back(bytes.below(3) + 1);
        break;
    case 3: // an image
        table.size.insert(table.size.begin(), bytes.below(4));
        break;
    case 4:
        table.size.clear();
        break;
    case 5:
        table.size.insert(table.size.end(), 4, 1);
        break;
    default: // a claim that nothing stands behind
        table.hollow = true;
        table.size.empty() ? void() : void(table.size[0] = hsize_t{1} << (bytes.below(31) + 10));
        table.bytes.clear();
        return;
    }
    refill(table);
}

/// Any attribute of the object, gone or of another type.
void edit_attribute(const Handle& file, const std::string& object, ByteSource& bytes) {
    const Handle opened(H5Oopen(file.get(), object.c_str(), H5P_DEFAULT), H5Oclose, object);
    const auto count = static_cast<std::size_t>(std::max(0, H5Aget_num_attrs(opened.get())));
    if (count == 0) {
        return;
    }
    std::array<char, 64> name{};
    H5Aget_name_by_idx(opened.get(), ".", H5_INDEX_NAME, H5_ITER_INC, bytes.below(count), name.data(), name.size(),
                       H5P_DEFAULT);
    H5Adelete(opened.get(), name.data());
    const auto kind = bytes.below(types().size() + 1);
    if (kind == types().size()) {
        return;
    }
    const hsize_t many = bytes.below(5);
    const Handle space(many == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &many, nullptr), H5Sclose, "space");
    const Handle attribute(H5Acreate2(opened.get(), name.data(), types()[kind], space.get(), H5P_DEFAULT, H5P_DEFAULT),
                           H5Aclose, "edit");
    const std::vector<std::uint64_t> values(8, bytes.next());
    H5Awrite(attribute.get(), types()[kind], values.data());
}

void edit_once(const Handle& file, ByteSource& bytes) {
    const auto paths = datasets_of(file);
    const auto kind = bytes.below(8);
    if (paths.empty() || kind == 0) {
        edit_attribute(file, paths.empty() || bytes.below(2) == 0 ? "/" : paths[bytes.below(paths.size())], bytes);
        return;
    }
    const auto& chosen = paths[bytes.below(paths.size())];
    if (kind == 1) {
        H5Ldelete(file.get(), chosen.c_str(), H5P_DEFAULT);
        return;
    }
    auto table = read_table(file, chosen);
    if (table.type < 0) {
        return;
    }
    if (kind == 2) {
        table.type = types()[bytes.below(types().size())];
        refill(table);
    } else if (kind == 3) {
        reshape(table, bytes);
    } else if (kind == 4) {
        table.wrong_checksum = true;
    } else {
        set_element(table, bytes);
    }
    write_table(file, chosen, table);
}

} // namespace

hsize_t Table::elements() const {
    return std::accumulate(size.begin(), size.end(), hsize_t{1}, std::multiplies<>());
}

void change_table(const std::filesystem::path& path, const std::string& dataset,
                  const std::function<void(Table&)>& change) {
    const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose, "the file just made opens");
    auto table = read_table(file, dataset);
    change(table);
    write_table(file, dataset, table);
}

void edit_stored(const std::filesystem::path& path, ByteSource& bytes) {
    silence_hdf5();
    const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose, "the file just made opens");
    for (int k = 0; k < 8 && !bytes.empty(); ++k) {
        try {
            edit_once(file, bytes);
        } catch (const Hdf5Failure&) {
            // An edit that HDF5 refuses, of 33 dimensions for example, leaves a file to look at all the same.
        }
    }
}

} // namespace nappe::fuzz
