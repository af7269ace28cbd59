#include "core/error.hpp"

#include <cstdio>
#include <cstdlib>

namespace nappe {

void assertion_failed(const char* condition, const char* file, int line, const std::string& values) {
    const char* rank = std::getenv("OMPI_COMM_WORLD_RANK");
    std::fprintf(stderr, "nappe: bug on rank %s: %s does not hold at %s:%d (%s)\n", rank ? rank : "0", condition, file,
                 line, values.c_str());
    std::abort();
}

} // namespace nappe
