#include "io/hdf5_structure.hpp"

#include "core/error.hpp"
#include "io/atomic_file.hpp"
#include "io/hdf5_handle.hpp"
#include "io/hdf5_slab.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <string>

namespace nappe {

namespace {

std::vector<hsize_t> dimensions(const Hdf5Dataset& dataset) {
    const auto rows = static_cast<hsize_t>(dataset.range.total);
    std::vector<hsize_t> size{rows};
    int columns = dataset.columns;
    if (dataset.image_width > 0) {
        size = {image_layers, rows, static_cast<hsize_t>(dataset.image_width)};
        columns /= dataset.image_width;
    }
    if (columns > 1) {
        size.push_back(static_cast<hsize_t>(columns));
    }
    return size;
}

Hdf5Handle create_dataset(const Hdf5Handle& file, const Hdf5Dataset& dataset, const Hdf5Handle& links) {
    const auto size = dimensions(dataset);
    const Hdf5Handle space(H5Screate_simple(static_cast<int>(size.size()), size.data(), nullptr), H5Sclose,
                           "no data space");
    const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "no property list");
    // Every row has its place in the file from the start; all are written, so filling them first would only cost time.
    // Times of creation would make equal data unequal files.
    hdf5_check(H5Pset_alloc_time(creation.get(), H5D_ALLOC_TIME_EARLY), "no allocation time");
    hdf5_check(H5Pset_fill_time(creation.get(), H5D_FILL_TIME_NEVER), "no fill time");
    hdf5_check(H5Pset_obj_track_times(creation.get(), false), "no times");
    return Hdf5Handle(H5Dcreate2(file.get(), dataset.path.c_str(), native_type(dataset.type), space.get(), links.get(),
                                 creation.get(), H5P_DEFAULT),
                      H5Dclose, "dataset " + dataset.path + " can not be created");
}

void write_attribute(const Hdf5Handle& file, const Hdf5Attribute& attribute) {
    const auto what = fmt::format("attribute {} of {} can not be written", attribute.name, attribute.object);
    const auto put = [&](hid_t type, const Hdf5Handle& space, const void* value) {
        const Hdf5Handle made(H5Acreate_by_name(file.get(), attribute.object.c_str(), attribute.name.c_str(), type,
                                                space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                              H5Aclose, what);
        hdf5_check(H5Awrite(made.get(), type, value), what);
    };
    const Hdf5Handle scalar(H5Screate(H5S_SCALAR), H5Sclose, "no data space");
    if (const auto* integer = std::get_if<std::int64_t>(&attribute.value)) {
        put(H5T_NATIVE_INT64, scalar, integer);
    } else if (const auto* bits = std::get_if<std::uint64_t>(&attribute.value)) {
        put(H5T_NATIVE_UINT64, scalar, bits);
    } else if (const auto* number = std::get_if<double>(&attribute.value)) {
        put(H5T_NATIVE_DOUBLE, scalar, number);
    } else if (const auto* text = std::get_if<std::string>(&attribute.value)) {
        const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "no type");
        const bool ascii = std::all_of(text->begin(), text->end(), [](char c) { return (c & 0x80) == 0; });
        hdf5_check(H5Tset_size(type.get(), std::max<std::size_t>(1, text->size())), what);
        hdf5_check(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), what);
        hdf5_check(H5Tset_cset(type.get(), ascii ? H5T_CSET_ASCII : H5T_CSET_UTF8), what);
        put(type.get(), scalar, text->c_str());
    } else {
        const auto put_list = [&](hid_t type, const auto& list) {
            const auto length = static_cast<hsize_t>(list.size());
            const Hdf5Handle space(H5Screate_simple(1, &length, nullptr), H5Sclose, "no data space");
            put(type, space, list.data());
        };
        if (const auto* numbers = std::get_if<std::vector<double>>(&attribute.value)) {
            put_list(H5T_NATIVE_DOUBLE, *numbers);
        } else {
            put_list(H5T_NATIVE_INT64, std::get<std::vector<std::int64_t>>(attribute.value));
        }
    }
}

void create_all(const Hdf5Handle& file, const Hdf5Content& content) {
    const Hdf5Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose, "no property list");
    hdf5_check(H5Pset_create_intermediate_group(links.get(), 1), "no groups");
    for (const auto& group : content.groups) {
        const Hdf5Handle made(H5Gcreate2(file.get(), group.c_str(), links.get(), H5P_DEFAULT, H5P_DEFAULT), H5Gclose,
                              "group " + group + " can not be created");
    }
    for (const auto& dataset : content.datasets) {
        create_dataset(file, dataset, links);
    }
    for (const auto& attribute : content.attributes) {
        write_attribute(file, attribute);
    }
}

/// No file of this content is longer: the rows, and a generous page of structure for each thing that has a name.
off_t longest(const Hdf5Content& content) {
    std::size_t bytes = 4096 * (16 + content.groups.size() + content.datasets.size() + content.attributes.size());
    for (const auto& dataset : content.datasets) {
        bytes += static_cast<std::size_t>(dataset.range.total * dataset.n_layers()) * dataset.row_bytes();
    }
    for (const auto& attribute : content.attributes) {
        const auto* text = std::get_if<std::string>(&attribute.value);
        bytes += text ? text->size() : 0;
    }
    return static_cast<off_t>(bytes);
}

[[noreturn]] void fail_to_make(const std::filesystem::path& path, std::string_view what, int error_number) {
    throw SystemError(fmt::format("{}: {}: {}", path.string(), what, remedy_for_writing(error_number)));
}

/// An HDF5 file without anything in it, as bytes. It is small and made in memory.
std::string empty_file() {
    constexpr std::size_t increment = 4096;
    const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "no property list");
    hdf5_check(H5Pset_fapl_core(access.get(), increment, false), "no files in memory");
    const Hdf5Handle file(H5Fcreate("empty", H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), H5Fclose, "no file in memory");
    hdf5_check(H5Fflush(file.get(), H5F_SCOPE_LOCAL), "no file in memory");
    const auto length = H5Fget_file_image(file.get(), nullptr, 0);
    hdf5_check(length, "no file in memory");
    std::string bytes(static_cast<std::size_t>(length), '\0');
    hdf5_check(H5Fget_file_image(file.get(), bytes.data(), bytes.size()), "no file in memory");
    return bytes;
}

/// The empty file, followed by room for all that will be in it.
void create_with_room(const std::filesystem::path& path, off_t length) {
    FileDescriptor file(path, O_RDWR | O_CREAT | O_TRUNC);
    const int reserved = ::posix_fallocate(file.get(), 0, length);
    // File systems that can not reserve say so with these; there the checks after writing must do.
    if (reserved != 0 && reserved != EOPNOTSUPP && reserved != EINVAL) {
        fail_to_make(path, fmt::format("no room for {:.1f} MB", static_cast<double>(length) / 1e6), reserved);
    }
    if (const int failure = write_all(file, empty_file())) {
        fail_to_make(path, "writing fails", failure);
    }
    if (const int failure = file.close()) {
        fail_to_make(path, "closing fails", failure);
    }
}

} // namespace

void create_hdf5_structure(const std::filesystem::path& path, const Hdf5Content& content) {
    create_with_room(path, longest(content));
    const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "no property list");
    hdf5_check(H5Pset_file_locking(access.get(), false, true), "file locking can not be set");
    Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, access.get()), H5Fclose,
                    "the file's structure can not be made");
    create_all(file, content);
    file.close("the file's structure can not be closed"); // gives back what was reserved too much
}

} // namespace nappe
