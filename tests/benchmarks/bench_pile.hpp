#pragma once
// The pile that the benchmarks of single stages work on: disks as deposited in a box, rows by tile, all on one rank.

#include "core/deposit.hpp"
#include "core/neighbours.hpp"
#include "solver/disk_contacts.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <vector>

namespace nappe::benchmarks {

inline constexpr double h = 0.025;     ///< step [s]
inline constexpr double margin = 0.08; ///< of every grain [m]: half the default skin

struct Pile {
    explicit Pile(int n_grains)
        : scene(make_scene(n_grains)), walls(scene.walls),
          grid(Vec<2>::Zero(), scene.tiles.side_for(scene.sample->radii.max)) {
        std::vector<GrainRecord<2>> records;
        for (const auto& row : deposit(*scene.sample, 2800.0, scene.gravity)) {
            records.push_back(to_record(row));
            records.back().margin = margin;
        }
        const auto key = [&](const GrainRecord<2>& g) { return grid.key(Vec<2>(g.x[0], g.x[1])); };
        std::sort(records.begin(), records.end(),
                  [&](const auto& p, const auto& q) { return key(p) != key(q) ? key(p) < key(q) : p.id < q.id; });
        state.assign(records, {}, walls.n_bodies());
        candidates = find();
        for (LocalId i = 0; i < state.n_held(); ++i) {
            state.u[i].v[1] -= h * 9.81;
        }
    }

    CandidateSet<2> find() const { return find_candidates(state, grid, walls, ContactMemory<2>()); }

    /// Packed for one step.
    DiskContacts contacts(const DiskKernels& kernels) const {
        DiskContacts packed(scene, kernels);
        auto copy = candidates; // pack puts impulses back
        packed.pack(state, copy, walls, h, false);
        return packed;
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
    TileGrid<2> grid;
    State<2> state;
    CandidateSet<2> candidates;
};

/// Made once a size: a deposit of 43,000 disks takes longer than what is measured on it.
inline const Pile& pile_of(std::int64_t n_grains) {
    static std::map<std::int64_t, std::unique_ptr<const Pile>> made;
    auto& pile = made[n_grains];
    if (!pile) {
        pile = std::make_unique<const Pile>(static_cast<int>(n_grains));
    }
    return *pile;
}

} // namespace nappe::benchmarks
