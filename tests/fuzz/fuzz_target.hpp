#pragma once
// What a fuzz target consists of (README.md): libFuzzer's four functions. It is linked either with libFuzzer (clang,
// preset fuzz) or with replay_main.cpp, which needs no clang and runs in the suite.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

extern "C" {
/// Once, before the first input.
int LLVMFuzzerInitialize(int* argc, char*** argv);
/// One input. Returns 0; aborts if the code under test did what it must not.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
/// Changes an input in place; returns its new size, at most max_size.
std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed);
/// Changes bytes blindly. Of libFuzzer, or of replay_main.cpp.
std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);
}

namespace nappe::fuzz {

/// Ends the process with a report of what was promised and what came instead.
[[noreturn]] inline void broken(const std::string& promise, const std::string& found) {
    std::fprintf(stderr, "broken: %s\nfound:  %s\n", promise.c_str(), found.c_str());
    std::abort();
}

/// Draws for edits of inputs: the same on every machine for one seed, so that a bounded campaign is the same everywhere.
class Draws {
public:
    explicit Draws(unsigned seed) : engine_(seed) {}
    /// 0 … n-1; 0 if n is 0
    std::size_t below(std::size_t n) { return n == 0 ? 0 : engine_() % n; }
    bool one_in(std::size_t n) { return below(n) == 0; }
    template <class List>
    const auto& any(const List& list) {
        return *(std::begin(list) + static_cast<std::ptrdiff_t>(below(std::size(list))));
    }

private:
    std::mt19937 engine_;
};

} // namespace nappe::fuzz
