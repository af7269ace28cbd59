#pragma once
// A scene stepped by a test, on one rank or on all. Needs an MpiSession: tests/mpi_main.cpp has it, so say RANKS in
// CMakeLists.txt.

#include "core/initial_grains.hpp"
#include "parallel/communicator.hpp"
#include "solver/observables.hpp"
#include "solver/simulation.hpp"
#include "support/scene_builder.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <vector>

namespace nappe::test {

inline double disk_mass(double radius, double density = 2800) {
    return density * std::numbers::pi * radius * radius;
}

/// Local, all of it, unless told otherwise: its communicator is MPI_COMM_SELF. With another one all is collective, and
/// what is asked for comes from all ranks, but for `simulation` and `state`.
class SerialRun {
public:
    /// At the start of stage 0. @param kernel "portable", "avx2", "avx512"; nullptr: the fastest
    explicit SerialRun(const Scene<2>& scene, const char* kernel = nullptr, MPI_Comm comm = MPI_COMM_SELF)
        : comm_(comm), simulation_(comm_, scene, disk_kernels(kernel)) {
        simulation_.load(comm_.is_root() ? initial_grains(scene) : std::vector<GrainRow<2>>{}, {}, step_of(0));
        simulation_.start_stage(0);
    }

    Simulation<2>& simulation() { return simulation_; }
    const State<2>& state() const { return simulation_.state(); }

    void steps(std::int64_t n, bool with_residual = false) {
        for (std::int64_t k = 0; k < n; ++k) {
            simulation_.step(0, with_residual);
        }
    }

    /// The same grains where they are, without a memory of impulses: the next step starts cold.
    void forget_impulses() {
        simulation_.load(simulation_.grain_rows(), {}, step_of(0));
        simulation_.start_stage(0);
    }

    std::vector<GrainRow<2>> grains() const { return comm_.all_gather(simulation_.grain_rows()); }

    GrainRow<2> grain(GlobalId id) const {
        const auto rows = grains();
        const auto it = std::find_if(rows.begin(), rows.end(), [id](const auto& row) { return row.id == id; });
        if (it == rows.end()) {
            throw std::logic_error("no grain " + std::to_string(id) + " in this run");
        }
        return *it;
    }

    /// Rim speed, radius x spin [m/s].
    double rim_speed(GlobalId id) const {
        const auto row = grain(id);
        return row.radius * row.spin[0];
    }

    /// Contacts that carried an impulse in the last step, be it a pull, by (lo, hi).
    std::vector<FrameContact<2>> loaded_contacts() const {
        auto rows = comm_.all_gather(frame_contacts(simulation_));
        std::erase_if(rows, [](const auto& row) { return row.r_n == 0; });
        std::sort(rows.begin(), rows.end(),
                  [](const auto& p, const auto& q) { return p.lo != q.lo ? p.lo < q.lo : p.hi < q.hi; });
        return rows;
    }

    /// Impulse of the last step between two grains, or between a grain and any part of wall `-1 - hi`; 0 if they do not touch.
    double normal_impulse(GlobalId lo, GlobalId hi) const {
        double sum = 0;
        for (const auto& row : loaded_contacts()) {
            if (row.lo == lo && (hi >= 0 ? row.hi == hi : row.wall == -1 - hi)) {
                sum += row.r_n;
            }
        }
        return sum;
    }

private:
    double step_of(std::size_t stage) const {
        const auto& s = simulation_.scene().stages[stage].solver;
        return s.h / s.substeps;
    }

    Communicator comm_;
    Simulation<2> simulation_;
};

/// The id of wall w as SerialRun::normal_impulse takes it.
inline GlobalId wall_id(int w) {
    return -1 - w;
}

} // namespace nappe::test
