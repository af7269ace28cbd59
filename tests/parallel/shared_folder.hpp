#pragma once
// A folder for the files of one test, the same on all ranks, gone when the test ends.

#include "parallel/communicator.hpp"

#include <cstdlib>
#include <filesystem>
#include <string>

namespace nappe::test {

class SharedFolder {
public:
    /// Collective over comm. Under `parent`, the system's folder for temporary files by default.
    explicit SharedFolder(const Communicator& comm, const std::filesystem::path& parent = {}) : comm_(comm) {
        std::string name;
        if (comm.is_root()) {
            const auto base = parent.empty() ? std::filesystem::temp_directory_path() : parent;
            name = (base / "nappe-test-XXXXXX").string();
            if (!::mkdtemp(name.data())) {
                name.clear();
            }
        }
        comm.broadcast(name);
        path_ = name;
    }
    /// Collective over comm.
    ~SharedFolder() {
        comm_.barrier();
        if (comm_.is_root() && !path_.empty()) {
            std::error_code ignored;
            std::filesystem::remove_all(path_, ignored);
        }
    }
    SharedFolder(const SharedFolder&) = delete;
    SharedFolder& operator=(const SharedFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }

private:
    const Communicator& comm_;
    std::filesystem::path path_;
};

} // namespace nappe::test
