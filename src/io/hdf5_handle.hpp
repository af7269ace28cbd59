#pragma once
// HDF5 identifiers that close themselves, and HDF5's error stack as one exception. hdf5.h itself stays in .cpp files.

#include <cstdint>
#include <stdexcept>
#include <string>

namespace nappe {

/// What HDF5 refused, in our words plus the innermost of its own. Never leaves src/io: callers turn it into a
/// SystemError on all ranks, or into the reason why a stored sample is not used.
struct Hdf5Failure : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Owns one HDF5 identifier. Local, but closing a file opened by several ranks is collective over them.
class Hdf5Handle {
public:
    using Id = std::int64_t;   // hid_t, checked in the .cpp
    using Close = int (*)(Id); // H5Fclose, H5Dclose …

    Hdf5Handle() = default;
    /// Throws Hdf5Failure(what) if `id` says that HDF5 could not make it.
    Hdf5Handle(Id id, Close closer, const std::string& what);
    ~Hdf5Handle();
    Hdf5Handle(Hdf5Handle&& other) noexcept;
    Hdf5Handle& operator=(Hdf5Handle&& other) noexcept;
    Hdf5Handle(const Hdf5Handle&) = delete;
    Hdf5Handle& operator=(const Hdf5Handle&) = delete;

    Id get() const { return id_; }
    explicit operator bool() const { return id_ >= 0; }

    /// Throws Hdf5Failure if HDF5 reports that closing failed: a file's last bytes are written then.
    void close(const std::string& what);

private:
    Id id_ = -1;
    Close close_ = nullptr;
};

/// Throws Hdf5Failure(what) if an HDF5 call returned a negative status.
void hdf5_check(std::int64_t status, const std::string& what);

/// HDF5 prints nothing by itself from now on: its errors are read where they occur, and said in our words. Local; whoever
/// opens or makes a file calls it. (It once was an object that silenced while it lived: of two whose lives overlap, the
/// first to go would have let HDF5 speak again.)
void silence_hdf5();

} // namespace nappe
