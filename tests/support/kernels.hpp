#pragma once
// The instruction sets that this machine has: tests that compare bits take each in turn.

#include "core/error.hpp"
#include "solver/disk_batch.hpp"

#include <vector>

namespace nappe::test {

inline std::vector<const char*> kernels_here() {
    std::vector<const char*> names;
    for (const char* name : {"scalar", "portable", "avx2", "avx512"}) {
        try {
            disk_kernels(name);
            names.push_back(name);
        } catch (const InputError&) {}
    }
    return names;
}

} // namespace nappe::test
