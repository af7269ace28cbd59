// Single stages alone, at 3,000 and 43,000 disks on one core: sweep and warm start per instruction set, packing, the
// search for candidates, colouring. `nappe bench` has the whole; this is for work on one of them. Run it on a quiet
// machine: build/ci/tests/benchmarks/benchmark.sweep --benchmark_filter=relax; compare figures of one run only.
#include "bench_pile.hpp"

#include "core/error.hpp"

#include <benchmark/benchmark.h>

namespace {

using namespace nappe;
using benchmarks::pile_of;

/// The seconds that one of `things` takes.
void per(benchmark::State& run, const char* thing, std::int64_t things) {
    const auto done = static_cast<double>(things) * static_cast<double>(run.iterations());
    run.counters[thing] = static_cast<double>(things);
    run.counters[std::string("s_per_") + thing] =
        benchmark::Counter(done, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

/// One pass over all tiles by a kernel, if this processor has it.
template <class Pass>
void over_tiles(benchmark::State& run, const char* kernel, Pass&& pass) {
    const DiskKernels* kernels = nullptr;
    try {
        kernels = &disk_kernels(kernel);
    } catch (const InputError& e) {
        run.SkipWithError(e.what());
        return;
    }
    const auto& pile = pile_of(run.range(0));
    auto contacts = pile.contacts(*kernels);
    auto u = pile.state.u;
    for (auto _ : run) {
        for (std::size_t t = 0; t < contacts.n_tiles(); ++t) {
            pass(contacts, t, u);
        }
    }
    per(run, "contact", contacts.n_active());
}

void relax(benchmark::State& run, const char* kernel) {
    over_tiles(run, kernel, [](auto& contacts, std::size_t t, auto& u) { contacts.relax(t, no_tile, u); });
}

/// Impulses are nil in a fresh pile: the arithmetic is the same.
void apply(benchmark::State& run, const char* kernel) {
    over_tiles(run, kernel, [](auto& contacts, std::size_t t, auto& u) { contacts.apply(t, u); });
}

/// @param anew as after a rebuild; else batches stay, and only normals and biases are new
void pack(benchmark::State& run, bool anew) {
    const auto& pile = pile_of(run.range(0));
    auto candidates = pile.candidates;
    DiskContacts contacts(pile.scene, disk_kernels());
    contacts.pack(pile.state, candidates, pile.walls, benchmarks::h, false);
    for (auto _ : run) {
        if (anew) {
            contacts.forget();
        }
        contacts.pack(pile.state, candidates, pile.walls, benchmarks::h, false);
    }
    per(run, "candidate", candidates.size());
}

void search(benchmark::State& run) {
    const auto& pile = pile_of(run.range(0));
    for (auto _ : run) {
        benchmark::DoNotOptimize(pile.find());
    }
    per(run, "grain", pile.state.n_own);
}

/// Tile by tile, contacts in the order that the search left: by class. Greedy colouring costs the same in any order but
/// for the classes it has to look at.
void colour(benchmark::State& run) {
    const auto& pile = pile_of(run.range(0));
    const auto& c = pile.candidates;
    std::vector<std::uint64_t> used(static_cast<std::size_t>(pile.state.n_held()));
    std::vector<std::int32_t> classes;
    for (auto _ : run) {
        for (const auto& tile : c.tiles) {
            const auto begin = static_cast<std::size_t>(tile.candidates_begin);
            const auto n = static_cast<std::size_t>(tile.candidates_end - tile.candidates_begin);
            colour_contacts(std::span(c.a).subspan(begin, n), std::span(c.b).subspan(begin, n), pile.state.n_held(),
                            used, classes);
            benchmark::DoNotOptimize(classes.data());
        }
    }
    per(run, "candidate", c.size());
}

void at_both_sizes(benchmark::internal::Benchmark* b) {
    b->Arg(3000)->Arg(43000)->Unit(benchmark::kMicrosecond);
}

BENCHMARK_CAPTURE(relax, scalar, "scalar")->Apply(at_both_sizes);
BENCHMARK_CAPTURE(relax, portable, "portable")->Apply(at_both_sizes);
BENCHMARK_CAPTURE(relax, avx2, "avx2")->Apply(at_both_sizes);
BENCHMARK_CAPTURE(relax, avx512, "avx512")->Apply(at_both_sizes);
BENCHMARK_CAPTURE(apply, scalar, "scalar")->Apply(at_both_sizes);
BENCHMARK_CAPTURE(apply, portable, "portable")->Apply(at_both_sizes);
BENCHMARK_CAPTURE(apply, avx2, "avx2")->Apply(at_both_sizes);
BENCHMARK_CAPTURE(apply, avx512, "avx512")->Apply(at_both_sizes);
BENCHMARK_CAPTURE(pack, anew, true)->Apply(at_both_sizes);
BENCHMARK_CAPTURE(pack, again, false)->Apply(at_both_sizes);
BENCHMARK(search)->Name("find_candidates")->Apply(at_both_sizes);
BENCHMARK(colour)->Name("colour_contacts")->Apply(at_both_sizes);

} // namespace

BENCHMARK_MAIN();
