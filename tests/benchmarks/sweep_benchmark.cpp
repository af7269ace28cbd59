// The sweep kernel alone, per instruction set and size: nanoseconds per relaxation of a deposit of disks, tile by tile,
// on one core. Run it on a quiet machine: build/ci/tests/benchmarks/benchmark.sweep; compare figures of one run only.
#include "core/deposit.hpp"
#include "core/error.hpp"
#include "core/neighbours.hpp"
#include "solver/disk_contacts.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace {

using namespace nappe;

/// A box of disks as deposited, packed for a step of 0.025 s.
struct Pile {
    Pile(int n_grains, const DiskKernels& kernels)
        : scene(make_scene(n_grains)), walls(scene.walls), contacts(scene, kernels) {
        const TileGrid<2> grid(scene.origin, scene.tiles.side_for(scene.sample->radii.max));
        std::vector<GrainRecord<2>> records;
        for (const auto& row : deposit(*scene.sample, 2800.0, scene.gravity)) {
            records.push_back(to_record(row));
            records.back().margin = 0.08;
        }
        const auto key = [&](const GrainRecord<2>& g) { return grid.key(Vec<2>(g.x[0], g.x[1])); };
        std::sort(records.begin(), records.end(),
                  [&](const auto& p, const auto& q) { return key(p) != key(q) ? key(p) < key(q) : p.id < q.id; });
        state.assign(records, {}, walls.n_bodies());
        candidates = find_candidates(state, grid, walls, ContactMemory<2>());
        for (LocalId i = 0; i < state.n_held(); ++i) {
            state.u[i].v[1] -= 0.025 * 9.81;
        }
        contacts.pack(state, candidates, walls, 0.025, false);
    }

    static Scene<2> make_scene(int n_grains) {
        Scene<2> s;
        s.gravity = Vec<2>(0, -9.81);
        s.materials = {{"wall", 0.0}, {"rock", 2800.0}};
        s.laws = {{1, 1, 0.4, 0.0}, {1, 0, 0.4, 0.0}};
        Sample<2> sample;
        sample.material = 1;
        sample.radii = {RadiusLaw::Kind::uniform, 0.42, 0.56};
        const double height = 30,
                     length = std::max(10.0, n_grains * 0.92 / height); // about 0.92 m² a disk, pores included
        sample.profile = {{0, 0}, {length, 0}, {length, height}, {0, height}};
        s.sample = sample;
        s.walls = {{"box", 0, {{0, 40}, {0, 0}, {length, 0}, {length, 40}}, {}}};
        return s;
    }

    Scene<2> scene;
    Walls<2> walls;
    DiskContacts contacts;
    State<2> state;
    CandidateSet<2> candidates;
};

void sweep(benchmark::State& run, const char* kernel) {
    std::unique_ptr<Pile> pile;
    try {
        pile = std::make_unique<Pile>(static_cast<int>(run.range(0)), disk_kernels(kernel));
    } catch (const InputError& e) {
        run.SkipWithError(e.what());
        return;
    }
    for (auto _ : run) {
        for (std::size_t t = 0; t < pile->contacts.n_tiles(); ++t) {
            pile->contacts.relax(t, pile->state.u);
        }
    }
    const auto relaxations = static_cast<double>(pile->contacts.n_active()) * static_cast<double>(run.iterations());
    run.counters["contacts"] = static_cast<double>(pile->contacts.n_active());
    run.counters["s_per_relaxation"] =
        benchmark::Counter(relaxations, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

BENCHMARK_CAPTURE(sweep, portable, "portable")->Arg(3000)->Arg(43000);
BENCHMARK_CAPTURE(sweep, avx2, "avx2")->Arg(3000)->Arg(43000);
BENCHMARK_CAPTURE(sweep, avx512, "avx512")->Arg(3000)->Arg(43000);

} // namespace

BENCHMARK_MAIN();
