// One fault of each kind that the sanitizers of the preset asan look for, on the last rank: proof that they see it there,
// and that the job then fails (must_find). Usage: planted KIND
#include "parallel/communicator.hpp"

#include <cstdint>
#include <cstdio>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace {

/// What the compiler can not know is still n.
template <class T>
T hidden(T n) {
    volatile T kept = n;
    return kept;
}

int heap_overflow() {
    std::vector<int> values(8, 1);
    return values.data()[hidden(8)];
}

int use_after_free() {
    auto* value = new int(hidden(3));
    delete value;
    return *hidden(value);
}

int past_the_end() {
    std::vector<int> values(8, 1);
    values.pop_back(); // within its memory, not within its size
    return values[hidden(std::size_t{7})];
}

int signed_overflow() {
    return hidden(std::numeric_limits<int>::max()) + 1;
}

int leak() {
    auto* lost = hidden(new std::int64_t[100]);
    lost[0] = 1;
    return static_cast<int>(lost[hidden(0)]);
}

int plant(const std::string& kind) {
    return kind == "heap_overflow"     ? heap_overflow()
           : kind == "use_after_free"  ? use_after_free()
           : kind == "past_the_end"    ? past_the_end()
           : kind == "signed_overflow" ? signed_overflow()
           : kind == "leak"            ? leak()
                                       : 0;
}

} // namespace

int main(int argc, char** argv) {
    nappe::MpiSession mpi(argc, argv);
    const nappe::Communicator world(MPI_COMM_WORLD);
    if (world.rank() == world.size() - 1 && argc == 2) {
        std::printf("planted: %d\n", plant(argv[1]));
    }
    world.barrier();
}
