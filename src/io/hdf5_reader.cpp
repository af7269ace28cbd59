#include "io/hdf5_reader.hpp"

#include "io/hdf5_slab.hpp"

#include <hdf5.h>

namespace nappe {

namespace {

Hdf5Handle open_attribute(const Hdf5Handle& file, const std::string& object, const std::string& attribute) {
    return Hdf5Handle(H5Aopen_by_name(file.get(), object.c_str(), attribute.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                      H5Aclose, "attribute " + attribute + " of " + object + " can not be opened");
}

template <class T>
T scalar(const Hdf5Handle& file, const std::string& object, const std::string& attribute) {
    const auto opened = open_attribute(file, object, attribute);
    const Hdf5Handle type(H5Aget_type(opened.get()), H5Tclose, "no type");
    const Hdf5Handle space(H5Aget_space(opened.get()), H5Sclose, "no data space");
    if (H5Tequal(type.get(), native_type(element_type<T>())) <= 0 || H5Sget_simple_extent_npoints(space.get()) != 1) {
        throw Hdf5Failure("attribute " + attribute + " of " + object + " has another type than expected");
    }
    T value{};
    hdf5_check(H5Aread(opened.get(), type.get(), &value), "attribute " + attribute + " can not be read");
    return value;
}

} // namespace

Hdf5Reader::Hdf5Reader(const std::filesystem::path& path) : file_(open_to_read(path.string())) {}

bool Hdf5Reader::has(const std::string& path) const {
    return H5Lexists(file_.get(), path.c_str(), H5P_DEFAULT) > 0;
}

std::int64_t Hdf5Reader::rows(const std::string& dataset) const {
    return dataset_rows(file_, dataset);
}

std::int64_t Hdf5Reader::stored_rows(const std::string& dataset) const {
    const auto n = rows(dataset);
    if (n < 0 || static_cast<std::uint64_t>(n) > stored_bytes(file_, dataset)) {
        throw Hdf5Failure("dataset " + dataset + " claims more rows than are stored");
    }
    return n;
}

std::vector<std::byte> Hdf5Reader::read_bytes(const std::string& dataset, ElementType type, int columns,
                                              std::int64_t first, std::int64_t n_rows) const {
    return read_slab(file_, dataset, type, columns, first, n_rows);
}

std::int64_t Hdf5Reader::integer(const std::string& object, const std::string& attribute) const {
    return scalar<std::int64_t>(file_, object, attribute);
}

std::uint64_t Hdf5Reader::bits(const std::string& object, const std::string& attribute) const {
    return scalar<std::uint64_t>(file_, object, attribute);
}

double Hdf5Reader::number(const std::string& object, const std::string& attribute) const {
    return scalar<double>(file_, object, attribute);
}

std::string Hdf5Reader::text(const std::string& object, const std::string& attribute) const {
    const auto opened = open_attribute(file_, object, attribute);
    const Hdf5Handle type(H5Aget_type(opened.get()), H5Tclose, "no type");
    const Hdf5Handle space(H5Aget_space(opened.get()), H5Sclose, "no data space");
    if (H5Tget_class(type.get()) != H5T_STRING || H5Tis_variable_str(type.get()) != 0 ||
        H5Sget_simple_extent_npoints(space.get()) != 1) {
        throw Hdf5Failure("attribute " + attribute + " of " + object + " is not a text");
    }
    std::string value(H5Tget_size(type.get()), '\0');
    hdf5_check(H5Aread(opened.get(), type.get(), value.data()), "attribute " + attribute + " can not be read");
    return value.substr(0, value.find('\0')); // null padded
}

} // namespace nappe
