// main() of a fuzz target without libFuzzer: every file of the corpus, then so many mutants of them, drawn alike on every
// machine. It knows nothing of coverage, so it finds little that is new; it keeps what was mended from coming back.
// Usage: TARGET MUTANTS PATH…     a PATH is an input or a folder of inputs
#include "fuzz/fuzz_target.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sys/resource.h>
#include <unistd.h>
#include <vector>

namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr std::size_t max_size = 8192; // as tools/fuzz has it
nappe::fuzz::Draws* blind = nullptr;

std::vector<Bytes> corpus_in(const std::vector<std::filesystem::path>& places) {
    std::vector<std::filesystem::path> files;
    for (const auto& place : places) {
        if (std::filesystem::is_directory(place)) {
            for (const auto& entry : std::filesystem::directory_iterator(place)) {
                files.push_back(entry.path());
            }
        } else {
            files.push_back(place);
        }
    }
    std::sort(files.begin(), files.end());
    std::vector<Bytes> corpus;
    for (const auto& path : files) {
        std::ifstream in(path, std::ios::binary);
        if (!in) {
            std::fprintf(stderr, "%s: must be a readable input, found none\n", path.c_str());
            std::exit(2);
        }
        corpus.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    }
    return corpus;
}

/// What one input may take: more than tools/fuzz allows, since this also runs beside other work. A sanitizer's own
/// bookkeeping is in no relation to that.
constexpr unsigned most_seconds = 60;
constexpr std::size_t most_bytes = std::size_t{512} << 20;

void bound_memory() {
#ifndef __SANITIZE_ADDRESS__
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlimit limit{pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)) + most_bytes, RLIM_INFINITY};
    ::setrlimit(RLIMIT_AS, &limit);
#endif
}

/// The input under way, for whoever has to find out what ended the process.
void run(const Bytes& input) {
    std::ofstream("fuzz-input", std::ios::binary)
        .write(reinterpret_cast<const char*>(input.data()), static_cast<std::streamsize>(input.size()));
    ::alarm(most_seconds); // a hang ends as SIGALRM
    LLVMFuzzerTestOneInput(input.data(), input.size());
}

} // namespace

std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t limit) {
    const auto at = blind->below(size);
    switch (blind->below(3)) {
    case 0:
        if (size < limit) {
            std::copy_backward(data + at, data + size, data + size + 1);
            data[at] = static_cast<std::uint8_t>(blind->below(256));
            return size + 1;
        }
        return size;
    case 1:
        if (size > 0) {
            std::copy(data + at + 1, data + size, data + at);
            return size - 1;
        }
        return size;
    default:
        if (size > 0) {
            data[at] = static_cast<std::uint8_t>(data[at] ^ (1U << blind->below(8)));
        }
        return size;
    }
}

int main(int argc, char** argv) {
    if (argc < 3) {
        std::fprintf(stderr, "usage: %s MUTANTS PATH…\n", argv[0]);
        return 2;
    }
    LLVMFuzzerInitialize(&argc, &argv);
    bound_memory();
    const auto mutants = std::strtoul(argv[1], nullptr, 10);
    const auto corpus = corpus_in({argv + 2, argv + argc});
    for (const auto& input : corpus) {
        run(input);
    }
    nappe::fuzz::Draws draws(1);
    blind = &draws;
    for (unsigned long k = 0; k < mutants; ++k) {
        Bytes input = draws.any(corpus);
        auto size = std::min(input.size(), max_size);
        input.resize(max_size);
        for (auto edits = draws.below(4) + 1; edits > 0; --edits) {
            size = LLVMFuzzerCustomMutator(input.data(), size, max_size, static_cast<unsigned>(draws.below(1U << 31)));
        }
        input.resize(size);
        run(input);
    }
    std::printf("%zu inputs of the corpus and %lu mutants\n", corpus.size(), mutants);
    return 0;
}
