#include "io/hdf5_handle.hpp"

#include <hdf5.h>

#include <type_traits>
#include <utility>

namespace nappe {

static_assert(std::is_same_v<hid_t, Hdf5Handle::Id> && std::is_same_v<herr_t, int>);

namespace {

/// Called from the innermost error outwards; the first one says most.
herr_t keep_first(unsigned, const H5E_error2_t* error, void* text) {
    auto& first = *static_cast<std::string*>(text);
    if (first.empty() && error->desc) {
        first = error->desc;
    }
    return 0;
}

[[noreturn]] void fail(const std::string& what) {
    std::string reason;
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_first, &reason);
    H5Eclear2(H5E_DEFAULT);
    throw Hdf5Failure(reason.empty() ? what : what + " (HDF5: " + reason + ")");
}

} // namespace

Hdf5Handle::Hdf5Handle(Id id, Close closer, const std::string& what) : id_(id), close_(closer) {
    if (id_ < 0) {
        fail(what);
    }
}

Hdf5Handle::~Hdf5Handle() {
    if (id_ >= 0) {
        close_(id_);
    }
}

Hdf5Handle::Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}

Hdf5Handle& Hdf5Handle::operator=(Hdf5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
}

void Hdf5Handle::close(const std::string& what) {
    if (id_ >= 0) {
        hdf5_check(close_(std::exchange(id_, -1)), what);
    }
}

void hdf5_check(std::int64_t status, const std::string& what) {
    if (status < 0) {
        fail(what);
    }
}

void silence_hdf5() {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

} // namespace nappe
