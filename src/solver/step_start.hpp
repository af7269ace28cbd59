#pragma once
// All that substeps change before a step is accepted, but impulses, which a step that is done again keeps as a first guess.

#include "core/contact_sums.hpp"
#include "core/energy_sums.hpp"
#include "core/state.hpp"
#include "core/walls.hpp"

#include <optional>
#include <vector>

namespace nappe {

/// Where grains and walls stood, and what the series had added up by then. By row while the lists stay; by name once
/// `name` has been called, which must be before rows change.
template <int D>
struct StepStart {
    bool held = false;
    std::vector<Vec<D>> x;
    std::vector<BodyVelocity<D>> u;
    std::vector<std::array<double, n_spin<D>>> rotation;
    std::vector<Vec<D>> offset, v_old;
    EnergySums<D> energy;
    std::optional<ContactSums<D>> sums;
    std::int64_t substeps = 0;
    double correction_work = 0;
    bool some_fast = false;
    std::optional<std::vector<GrainRecord<D>>> records; ///< of the grains owned then

    /// Local. Pre: held, rows as they were then.
    void name(const State<D>& state) {
        if (records) {
            return;
        }
        records.emplace();
        records->reserve(static_cast<std::size_t>(state.n_own));
        for (LocalId i = 0; i < state.n_own; ++i) {
            GrainRecord<D> g = state.record(i);
            g.u = u[static_cast<std::size_t>(i)];
            for (int d = 0; d < D; ++d) {
                g.x[static_cast<std::size_t>(d)] = x[static_cast<std::size_t>(i)][d];
            }
            if (!rotation.empty()) {
                g.rotation = rotation[static_cast<std::size_t>(i)];
            }
            records->push_back(g);
        }
    }
};

} // namespace nappe
