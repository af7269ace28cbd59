#pragma once
// A few pairs of disks and a floor, for tests of what a step packs.

#include "core/neighbours.hpp"
#include "solver/disk_contacts.hpp"

#include <map>
#include <vector>

namespace nappe::test {

inline constexpr double h = 0.01, r = 0.5;

/// A row of pairs far apart: pair k has gap[k] and closes at approach[k]; one more grain stands over a floor at a gap of 0.2 r.
struct Fixture {
    explicit Fixture(const std::vector<double>& gaps, const std::vector<double>& approaches, double restitution = 0,
                     double friction_of_floor = 0.5) {
        scene.materials = {{"rock", 1}, {"floor", 0}};
        scene.laws = {{0, 0, 0.5, restitution}, {0, 1, friction_of_floor, restitution}};
        Wall<2> floor;
        floor.name = "floor";
        floor.material = 1;
        floor.points = {{-1, 0}, {3, 0}};
        scene.walls = {floor};
        walls = Walls<2>(scene.walls);
        std::vector<GrainRecord<2>> grains;
        const auto add = [&](double x, double y, double vx, double mass) {
            GrainRecord<2> g;
            g.id = static_cast<GlobalId>(grains.size());
            g.x = {x, y};
            g.u.v = {vx, 0};
            g.u.inv_m = 1 / mass;
            g.mass = mass;
            g.radius = r;
            g.margin = 1;
            grains.push_back(g);
        };
        add(1, 1.2 * r, 0, 2);
        for (std::size_t k = 0; k < gaps.size(); ++k) {
            const double x = 20.0 * static_cast<double>(k + 1);
            add(x, 10, approaches[k], 2);
            add(x + 2 * r + gaps[k], 10, 0, 3);
        }
        state.assign(grains, {}, walls.n_bodies());
        for (LocalId k = state.n_held(); k < state.null_body(); ++k) {
            state.material[k] = 1;
        }
        candidates = find_candidates(state, TileGrid<2>({0, 0}, 1000), walls, {});
    }

    /// Lower ids of the packed grain pairs, with what was packed.
    struct Packed {
        Vec<2> n;
        double r_n, r_t;
        bool wall;
    };
    std::map<GlobalId, Packed> packed(const DiskContacts& contacts) const {
        std::map<GlobalId, Packed> found;
        for (std::size_t t = 0; t < contacts.n_tiles(); ++t) {
            contacts.for_each(t, [&](LocalId a, LocalId b, const Vec<2>& n, double r_n, double r_t) {
                found[state.id[a]] = {n, r_n, r_t, b >= state.n_held()};
            });
        }
        return found;
    }

    Scene<2> scene;
    Walls<2> walls = Walls<2>(std::vector<Wall<2>>{});
    State<2> state;
    CandidateSet<2> candidates;
};

} // namespace nappe::test
