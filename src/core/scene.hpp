#pragma once
// The scene as the computation sees it: numbers in SI units, names resolved to indices, every rule already checked by
// whoever filled it (io/scene_reader.hpp reads it from TOML; tests fill it by hand). docs/scene.md documents the keys.

#include "core/types.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace nappe {

struct Material {
    std::string name;
    double density = 0; ///< [kg/m³] in the plane: mass per metre of depth; 0 for materials only walls are made of
    std::optional<double> gamma = std::nullopt; ///< [N], of its cohesive laws that give none themselves
    std::optional<double> d_w = std::nullopt;   ///< [m], likewise
    /// Cundall's global damping of its grains, per metre of depth: C [N s/m] and C* [N m s], (seeds/004 eq. 15, 16).
    double damping = 0;
    double spin_damping = 0;
};

/// A spring and a dashpot, per metre of depth.
struct SpringDashpot {
    double k = 0; ///< [N/m]
    /// [N s/m]; none: 2 sqrt(m k_n) with m = m_a m_b / (m_a + m_b), which stops a head-on pair without a rebound.
    std::optional<double> c = std::nullopt;
};

/// What Cundall's smooth model adds to a law (seeds/004 eq. 9, 10).
struct Springs {
    SpringDashpot normal, tangential;
};

/// Signorini–Coulomb with Newton restitution or with cohesion (the non-smooth Lennard-Jones law, seeds/000 §4.3), for
/// one unordered pair of materials.
struct ContactLaw {
    int material_a = 0;
    int material_b = 0;
    double friction = 0;    ///< mu
    double restitution = 0; ///< e, in [0, 1]; 0 with cohesion
    double gamma = 0;       ///< greatest attraction [N], per metre of depth; none while the sample is prepared
    double d_w = 0;         ///< gap up to which a pair is bonded [m]

    std::optional<Springs> springs = std::nullopt; ///< what stages with method = cundall go by

    double range() const { return gamma > 0 ? d_w : 0.0; } ///< without an attraction there is no bond
};

struct RadiusLaw {
    enum class Kind { uniform, constant };
    Kind kind = Kind::uniform;
    double min = 0; ///< [m]; constant: min == max
    double max = 0; ///< [m]
};

/// Grains deposited inside a profile (core/deposit.hpp), or on a lattice (core/lattice.hpp).
template <int D>
struct Sample {
    enum class Arrangement { deposit, square, staggered };
    Arrangement arrangement = Arrangement::deposit;
    int material = 0;
    RadiusLaw radii;
    std::vector<Vec<D>> profile; ///< closed polygon [m], either orientation, not self-crossing
    /// Heights [m], ascending: layer k (from 1) lies below layer_tops[k-1]; above all: n+1.
    std::vector<double> layer_tops;
    std::uint64_t seed = 1;
};

/// A grain given one by one; these follow the sample's grains in the order of GlobalId, those to be dropped last.
template <int D>
struct SingleGrain {
    int material = 0;
    double radius = 0; ///< [m]
    Vec<D> position = Vec<D>::Zero();
    Vec<D> velocity = Vec<D>::Zero();
    Eigen::Matrix<double, n_spin<D>, 1> spin = Eigen::Matrix<double, n_spin<D>, 1>::Zero(); ///< [rad/s]
    int layer = 1;
    bool drop = false; ///< comes when loading starts, see commands/drop.hpp
};

/// Constant velocity from the start of a stage, or from a time on, until an optional end.
template <int D>
struct Motion {
    Vec<D> velocity = Vec<D>::Zero(); ///< [m/s]
    int stage = -1;                   ///< index into Scene::stages; -1: `start` counts instead
    double start = 0;                 ///< [s] of loading time
    std::optional<double> stop;       ///< [s] of loading time
};

/// A rigid polyline; a grain may touch it from either side, its end points and its joints too. First point == last
/// point closes it.
template <int D>
struct Wall {
    std::string name;
    int material = 0;
    std::vector<Vec<D>> points; ///< at least 2 [m]
    std::optional<Motion<D>> motion;
};

struct SolverSettings {
    /// solver/nsgs.hpp and its neighbours say what each is; cundall: smooth contacts, nothing to solve (solver/smooth.cpp).
    enum class Method { nsgs, ansgs, nncg, apgd, cpg, cundall };
    enum class AtMax { accept, stop };
    enum class Coupling { colour, sweep }; ///< when ranks exchange velocities: after each tile colour, or each sweep
    enum class Precision { full, single }; ///< of the sweep; what is outside of it is always in double
    Method method = Method::nsgs;
    double h = 0;     ///< step [s]
    int substeps = 1; ///< a step is integrated as this many of h / substeps, its sweeps divided among them (rounded up)
    double theta = 0.5; ///< in [1/2, 1]
    int sweeps = 100;   ///< fixed count, or the least when a tolerance is set
    /// On the residual (docs/notation.md), relative to V.
    std::optional<double> tolerance;
    int max_sweeps = 1000; ///< with a tolerance
    /// What becomes of a step that is not within the tolerance after max_sweeps: counted as unconverged and accepted, or
    /// NumericalFailure.
    AtMax at_max = AtMax::accept;
    int check_every = 10; ///< sweeps between two checks of the tolerance
    /// Share of V below which a tile's changes do not matter: it is left alone until its surroundings change (nsgs only).
    std::optional<double> adaptive;
    int geometry_every = 1; ///< substeps that normals serve for; no more than the substeps of a step
    /// Share of each overlap that is taken away at the end of a (sub)step, as far as contacts have dissipated energy to pay
    /// for it; in [0, 1].
    double position_correction = 0;
    bool warm_start = true;                ///< from the impulses of the step before; else from none
    Coupling coupling = Coupling::colour;  ///< nsgs only; `sweep`: the result depends on the number of ranks
    Precision precision = Precision::full; ///< nsgs only
    bool unsafe = false; ///< cundall only: steps that may not be stable, and springs too soft to keep grains apart
};

/// Of a smooth stage, which has none of the keys of a solution. theta = 1: forces are found where a step begins, and
/// positions go by the new velocity (seeds/004 eq. 23).
inline SolverSettings smooth_settings(double h, int substeps = 1) {
    SolverSettings s;
    s.method = SolverSettings::Method::cundall;
    s.h = h;
    s.substeps = substeps;
    s.theta = 1;
    s.sweeps = 1;
    return s;
}

inline bool is_smooth(const SolverSettings& settings) {
    return settings.method == SolverSettings::Method::cundall;
}

/// Ends a preparing stage: both that its contacts have hold at the end of a step.
struct SettleCriterion {
    double kinetic = 1e-8;    ///< kinetic energy over (total weight x mean radius)
    double residual = 1e-4;   ///< rigid: of the last step, relative to V
    double unbalanced = 1e-3; ///< smooth: resultant forces over all that act (solver/smooth_energy.hpp)
    double at_most = 1000;    ///< [s]; not settled by then: NumericalFailure
};

/// Stages run in order. Those with `until` prepare the sample and come first; loading time is 0 when they end.
struct Stage {
    std::string name;
    std::optional<SettleCriterion> until;
    double duration = 0;   ///< [s], if no `until`
    SolverSettings solver; ///< the scene's, with this stage's own keys over it
};

/// Steps of a stage with a duration: the whole number nearest to duration / h, at least 1.
inline std::int64_t n_steps(const Stage& stage) {
    return std::max<std::int64_t>(1, std::llround(stage.duration / stage.solver.h));
}

template <int D>
struct Cell {
    std::string name;
    Vec<D> centre = Vec<D>::Zero(); ///< [m]
    double radius = 0;              ///< [m]
};

/// Pressure gauges side by side: equal bins of a part of a wall, which move with it.
struct Gauge {
    std::string name;
    int wall = 0;            ///< index into Scene::walls
    double from = 0, to = 0; ///< along the wall from its first point [m]
    int bins = 1;
    int every = 0; ///< steps of loading between two rows; 0: as the series
};

/// A single grain that is looked at.
struct Probe {
    std::string name;
    GlobalId grain = 0; ///< < 0: counting from the last, -1
    int every = 0;      ///< steps of loading between two rows; 0: as the series
    std::string place;  ///< where the scene names the grain: file, line and key
};

/// What is measured on frames (docs/measures.md).
struct MeasureSettings {
    bool during_run = false; ///< at every frame of the run; `nappe measure` does it afterwards
    double spacing = 0;      ///< between nodes of the grid of fields [m]; 0: 4 mean radii, no more than the range
    double range = 0;        ///< w of the coarse-graining kernel [m]; 0: 8 mean radii, at least the spacing
    bool energy = false;     ///< series/energy.csv gets the budget

    double spacing_for(double mean_radius) const { ///< default worked out [m]
        return spacing > 0 ? spacing : range > 0 ? std::min(4 * mean_radius, range) : 4 * mean_radius;
    }
    double range_for(double mean_radius) const { ///< default worked out [m]
        return range > 0 ? range : std::max(8 * mean_radius, spacing);
    }
};

/// Where a fault starts and what drives it: the limits of its zone are looked for.
template <int D>
struct FaultZone {
    int wall = 0;                ///< index into Scene::walls: it moves with the block that is pushed
    Vec<D> tip = Vec<D>::Zero(); ///< of the fault when loading starts [m]
    double tolerance = 0.1;      ///< what counts as rigid and as rest, over the wall's speed
};

template <int D>
struct Output {
    int frames_every = 0;       ///< steps of loading; 0: only the first and the last state
    int series_every = 10;      ///< steps of loading between two rows of the series
    std::vector<Cell<D>> cells; ///< sets of grains inside the circle when loading starts; at most 64
    std::vector<Gauge> gauges;
    std::vector<Probe> probes;
    double front_bin = 0; ///< width of the bins of the free surface [m]; 0: four mean radii
    MeasureSettings measures;
    std::optional<FaultZone<D>> zone;

    double bin_for(double mean_radius) const { return front_bin > 0 ? front_bin : 4 * mean_radius; } ///< [m]
};

struct TileSettings {
    double side = 0;       ///< S [m]; 0: 16 r_max
    double skin = 0;       ///< least distance two grains may approach before the next rebuild [m]; 0: 0.6 r_max
    double lookahead = 18; ///< steps for which a moving grain's margin should last

    double large_above = 0; ///< radius [m]; 0: see core/large_grains.hpp

    double side_for(double r_max) const { return side > 0 ? side : 16 * r_max; } ///< defaults worked out [m]
    double skin_for(double r_max) const { return skin > 0 ? skin : 0.6 * r_max; }
};

struct BalanceSettings {
    enum class By { work, time };              ///< counted relaxations, or measured seconds
    enum class Moves { when_it_pays, always }; ///< always: for tests, since measured time has no part in it
    double threshold = 1.01;                   ///< largest over mean load per rank, above which tiles may move
    int every = 200;                           ///< steps between two looks
    By by = By::work;                          ///< what load is
    Moves moves = Moves::when_it_pays;
};

/// What is looked at in every step ([watch]; solver/watcher.hpp), and what becomes of a step in which it is found.
template <int D>
struct WatchSettings {
    /// substep: the step is done again with twice the substeps, and again, and ends the run if max_substeps do not help;
    /// while a sample is prepared it only warns, so that samples do not depend on it.
    enum class Then { warn, substep, stop };
    struct Overlap {
        double limit = 0.8; ///< largest -gap at the end of a (sub)step, over the smaller radius
        Then then = Then::warn;
    };
    struct Energy {
        double limit = 0.1; ///< of what grew without work, over kinetic energy + work of walls + weight x mean radius
        Then then = Then::warn;
    };
    struct Residual {
        int steps = 10; ///< in a row that end above solver.tolerance
        Then then = Then::warn;
    };
    struct Bounds { ///< of all centres [m]
        Vec<D> min = Vec<D>::Zero(), max = Vec<D>::Zero();
        Then then = Then::stop;
    };
    Overlap overlap;
    Energy energy;
    Residual residual;
    std::optional<Bounds> bounds; ///< none: what tiles can name
    Then failure = Then::stop; ///< a step that can not be taken (not finite, too fast, through something); never warn
    int max_substeps = 64;     ///< of a step that is done again
};

template <int D>
struct Scene {
    std::string title;
    std::string text;                ///< the scene as run: the file with overrides applied, as TOML
    Vec<D> gravity = Vec<D>::Zero(); ///< [m/s²]
    /// Of coordinates [m]: all positions of a scene and of what is computed are relative to it, so that a double places
    /// a grain as well anywhere on Earth; files hold them with it. A corner of the tile grid lies here.
    Vec<D> origin = Vec<D>::Zero();
    std::vector<Material> materials;
    std::vector<ContactLaw> laws;
    std::optional<Sample<D>> sample;
    std::vector<SingleGrain<D>> grains;
    std::vector<Wall<D>> walls;
    std::vector<Stage> stages;
    Output<D> output;
    TileSettings tiles;
    BalanceSettings balance;
    WatchSettings<D> watch;
};

/// Largest gap at which any pair is bonded [m].
template <int D>
double largest_range(const Scene<D>& scene) {
    double range = 0;
    for (const auto& law : scene.laws) {
        range = std::max(range, law.range());
    }
    return range;
}

/// Whether results depend on the number of ranks: some stage is coupled once a sweep.
template <int D>
bool couples_by_sweep(const Scene<D>& scene) {
    return std::any_of(scene.stages.begin(), scene.stages.end(),
                       [](const Stage& stage) { return stage.solver.coupling == SolverSettings::Coupling::sweep; });
}

/// Whether some loading stage is smooth: its budget of energy has springs.
template <int D>
bool loads_springs(const Scene<D>& scene) {
    return std::any_of(scene.stages.begin(), scene.stages.end(),
                       [](const Stage& stage) { return !stage.until && is_smooth(stage.solver); });
}

/// The law between two materials, or nullptr if the scene has none.
template <int D>
const ContactLaw* find_law(const Scene<D>& scene, int material_a, int material_b) {
    for (const auto& law : scene.laws) {
        if ((law.material_a == material_a && law.material_b == material_b) ||
            (law.material_a == material_b && law.material_b == material_a)) {
            return &law;
        }
    }
    return nullptr;
}

/// The (sub)step whose impulses are in force after `step` steps of loading: that of the loading stage this step ends in,
/// of the first for step 0 [s].
template <int D>
double impulse_step(const Scene<D>& scene, std::int64_t step) {
    const Stage* stage = &scene.stages.back();
    std::int64_t end = 0;
    for (const auto& next : scene.stages) {
        if (!next.until) {
            stage = &next;
            end += n_steps(next);
            if (step <= end) {
                break;
            }
        }
    }
    return stage->solver.h / stage->solver.substeps;
}

} // namespace nappe
