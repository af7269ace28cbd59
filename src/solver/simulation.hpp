#pragma once
// A running scene: grains, walls, candidates, clock, and the step that moves them (step.cpp). Knows nothing of files.

#include "core/contact_set.hpp"
#include "core/contact_sums.hpp"
#include "core/energy_sums.hpp"
#include "core/passage.hpp"
#include "core/scene.hpp"
#include "core/snapshot.hpp"
#include "core/state.hpp"
#include "core/stopwatch.hpp"
#include "core/walls.hpp"
#include "parallel/domain.hpp"
#include "solver/contact_solver.hpp"
#include "solver/step_start.hpp"
#include "solver/tile_costs.hpp"
#include "solver/undo.hpp"
#include "solver/watcher.hpp"

#include <optional>
#include <vector>

namespace nappe {

/// Counted since the sample was loaded; per rank unless it says global.
struct Counters {
    std::int64_t steps = 0;         ///< global
    std::int64_t relaxations = 0;   ///< contacts relaxed, padding not counted
    std::int64_t sweeps = 0;        ///< global
    std::int64_t rebuilds = 0;      ///< global
    std::int64_t redone_lists = 0;  ///< global: steps redone since a grain outran its margin
    std::int64_t redone_groups = 0; ///< global: groups of substeps redone with a geometry each
    std::int64_t redone_packs = 0;  ///< global: steps redone since a contact left out came to act
    std::int64_t reductions = 0;    ///< global: sums that methods waited for
    std::int64_t unconverged = 0;   ///< global: steps that reached max_sweeps
    std::int64_t rebalanced = 0;    ///< global
};

/// Bits that ranks agree on at the end of every step by one Allreduce.
namespace flag {
inline constexpr std::uint32_t not_finite = 1u << 0;
inline constexpr std::uint32_t outran_list = 1u << 1;
inline constexpr std::uint32_t missed_contact = 1u << 2;
inline constexpr std::uint32_t rebuild_next = 1u << 3;
inline constexpr std::uint32_t through_wall = 1u << 4;
inline constexpr std::uint32_t too_fast = 1u << 5; ///< a grain moves farther in a step than tiles allow
inline constexpr std::uint32_t fast = 1u << 6;     ///< a grain moves more than slow_stride of its radius in a step
inline constexpr std::uint32_t passed = 1u << 7;   ///< a grain went through another, or through a wall
inline constexpr std::uint32_t deep = 1u << 8;     ///< an overlap beyond watch.overlap.limit
inline constexpr std::uint32_t outside = 1u << 9;  ///< a centre outside watch.bounds
inline constexpr std::uint32_t grown = 1u << 10;   ///< energy of a smooth step, perhaps: to be looked at
inline constexpr std::uint32_t outside_first = 1u << 16; ///< bits from here on are the caller's: signals, I/O errors
} // namespace flag

template <int D>
class Simulation {
public:
    /// **Collective.** @param kernels of one instruction set; results do not depend on it.
    Simulation(const Communicator& comm, const Scene<D>& scene, const DiskKernels& kernels);

    /// **Collective.** Takes a sample, rows in any order on any ranks. Wall displacements and clock go back to 0.
    /// @param h the step [s] whose impulses these are.
    void load(const std::vector<GrainRow<D>>& grains, const std::vector<ContactRow<D>>& impulses, double h);

    /// **Collective.** The next steps belong to this stage. Rebuilds lists: every stage starts from the same state
    /// whether the one before it was computed or its result loaded.
    void start_stage(int stage);

    /// **Collective.** Marks the grains inside the scene's cells and starts its energy budget, if it wants one; called
    /// when loading starts.
    void mark_cells();

    /// **Collective.** All that the next step depends on, between two steps.
    Snapshot<D> snapshot() const;

    /// **Collective.** In place of `load` and `start_stage`: goes on from a snapshot, to the same bits on any number of
    /// ranks. Pre: the snapshot's grains, walls, stages and cells are those of the scene; the settings of its solver may be
    /// others (not h of the stage in hand).
    void resume(const Snapshot<D>& from);

    /// **Collective.** Advances by the stage's h. @param outside bits of the caller, >= flag::outside_first
    /// @returns those bits of all ranks. Throws NumericalFailure (NaN, a grain through a wall or too fast, or what the
    /// scene's [watch] says), naming the grain, on all ranks alike.
    std::uint32_t step(std::uint32_t outside = 0, bool with_residual = false);

    /// **Collective.** After `step` threw NumericalFailure: all that `snapshot` takes is what it was at the start of that
    /// step, or after the rebuild that it began with; the next step goes on to the same bits. False: that rebuild had not
    /// ended, and nothing here can be used.
    bool undo_step();

    /// Of the last step, if it was asked for.
    const std::optional<Residual>& last_residual() const { return last_residual_; }
    int last_sweeps() const { return last_sweeps_; }

    const Scene<D>& scene() const { return scene_; }
    const Communicator& comm() const { return comm_; }
    const State<D>& state() const { return state_; }
    const Walls<D>& walls() const { return walls_; }
    const Domain<D>& domain() const { return domain_; }
    /// With the impulses of the last step.
    const CandidateSet<D>& candidates() const {
        if (impulses_stale_) {
            keep_impulses();
            settle_records();
            contacts_.store(candidates_);
            impulses_stale_ = false;
        }
        return candidates_;
    }
    const ContactsOf<D>& contacts() const {
        settle_records();
        return contacts_;
    }
    /// Of bodies, kept by the method and by the correction of positions: what fields.hpp lists under "Iteration" and
    /// "Simulation". Pre: a step.
    std::size_t bytes_of_method() const { return solver_.bytes_of_method(); }
    std::size_t bytes_of_correction() const { return correction_.size() * sizeof(BodyVelocity<D>); }
    const Counters& counters() const { return counters_; }
    /// Potential energy that the correction of positions has put in since the sample was loaded, of all grains [J].
    double correction_work() const { return correction_work_; }
    const Watcher& watcher() const { return watcher_; }
    Watcher& watcher() { return watcher_; }
    ContactSums<D>& sums() { return sums_; }
    /// This rank's part, since `mark_cells`, if the scene wants an energy budget.
    const EnergySums<D>& energy() const { return energy_; }
    Stopwatch& watch() { return watch_; }
    const SolverSettings& settings() const { return scene_.stages[static_cast<std::size_t>(stage_)].solver; }
    int stage() const { return stage_; }
    /// In this stage's clock [s].
    double time() const { return stage_start_ + static_cast<double>(stage_steps_) * settings().h; }
    std::int64_t stage_steps() const { return stage_steps_; }
    double mean_radius() const { return mean_radius_; } ///< of all grains [m]
    double total_mass() const { return total_mass_; }   ///< of all grains [kg]
    double skin() const { return skin_; }               ///< [m]

    /// Local. Owned grains and impulses as rows: a sample, if taken between steps.
    std::vector<GrainRow<D>> grain_rows() const;
    std::vector<ContactRow<D>> contact_rows() const { return impulse_rows(state_, candidates()); }

    /// **Collective.** Of positions, velocities, rotations, radii and impulses by name; the same on any number of
    /// ranks.
    std::uint64_t state_hash() const;

private:
    // One stage of the step each, in this order (step.cpp).
    enum class Start { warm, as_it_is };               ///< as_it_is: u has the impulses in it already
    enum class Outcome { taken, separately, shorter }; ///< separately: with a geometry each; shorter: the whole step
    struct Solve {
        double h;
        int sweeps;
        std::uint32_t outside; ///< the caller's bits
        bool with_residual;
    };
    bool take_step(std::uint32_t outside, bool with_residual); // substeps.cpp
    Outcome kept_substeps(int n, const Solve& solve);
    void predict_kept(double h);
    void put_back(const StepStart<D>& start);
    void keep(StepStart<D>& start) const;
    void go_back();
    void note_start(); // undo.cpp
    void keep_impulses() const;
    void secure_start();
    void put_springs_back();
    void change_substep(double h);
    bool substep(const Solve& solve);
    void begin_substep();
    void renew_lists();
    void agree(double h, int n, const PackFaults& faults, std::uint32_t outside, const StepStart<D>* start = nullptr);
    void end_substep(double h);
    bool walls_change_speed() const;
    bool corrects() const { return settings().position_correction > 0; }
    bool smooth() const { return is_smooth(settings()); }
    /// What the grains of a smooth step did on this rank.
    struct Moved {
        double fastest_squared = 0;       ///< [m²/s²]
        double zeros = 0;                 ///< NaN if something is not finite
        double kinetic = 0;               ///< of grains owned [J]
        Vec<D> momentum = Vec<D>::Zero(); ///< likewise [N s]
        SmoothTally met;                  ///< deeper: than depth_share() of the smaller radius
    };
    bool smooth_substep(const Solve& solve); // smooth.cpp
    void press(double h, Moved& moved, PackFaults& faults);
    bool nothing_to_look_for(double h, const Moved& moved);
    bool may_have_grown(double h, const Moved& moved) const;
    std::uint32_t look_closely(double h, const PackFaults& faults);
    void step_back();
    double least_room(double h) const;
    double near_gap() const;
    double depth_share() const;
    GrainArrays grain_arrays();
    void find_damping(double h);
    template <class F>
    void for_each_smooth(std::size_t tile, double h, F&& f) const; // smooth_energy.cpp
    void collect_springs(std::size_t tile, double h);
    SpringEnergy spring_growth(double h) const;
    void settle_records() const;
    bool give_up(int attempt) const;
    void redo_with_lists(double h);
    void predict_walls(double ahead);
    void integrate_walls(double h);
    void note_gain(double h); // correction.cpp
    void correct_positions(double h, int sweeps);
    void move_apart(double h);
    double dissipation();
    void predict(double h);
    PackFaults detect(double h, bool activate_all);
    void solve(double h, int sweeps, Start start, bool with_residual);
    std::uint32_t check(double h, int n, const PackFaults& faults, const StepStart<D>* start);
    void integrate(double h);
    void collect();
    void collect_energy(double h);
    void find_reported_tiles();

    void take(std::vector<GrainRecord<D>> records, const std::vector<ContactRow<D>>& impulses,
              const std::vector<TileOwner>& owners);
    void take_sums(const Snapshot<D>& from); // snapshot.cpp
    Snapshot<D> snapshot_with(const CandidateSet<D>& candidates, ContactSums<D> sums, EnergySums<D> energy) const;
    SnapshotClock clock() const;
    void set_clock(const SnapshotClock& clock);
    void configure_stage();
    void rebuild();
    void relist();
    void find_bonds();
    void drive_walls();
    void rescale_impulses(double h);
    void set_margins();
    void widen_margins(double h);
    bool rebalance_if_due();
    void place_walls();
    double largest_margin() const { return domain_.largest_margin(r_max_, state_.attraction); }
    double velocity_scale(double h) const;
    enum class EnergyLook { none, judge, remember }; ///< remember: what growth is compared with later on as well
    // The watch. `start`: of n > 1 substeps that share their normals.
    void gauge(const Tile& tile, double h, const StepStart<D>* start); // watch_step.cpp
    std::uint32_t read_gauge(double h, int n, const StepStart<D>* start);
    bool heed(double h, int n, const StepStart<D>* start, EnergyLook look = EnergyLook::remember);
    bool preparing() const { return scene_.stages[static_cast<std::size_t>(stage_)].until.has_value(); }
    bool may_divide(typename WatchSettings<D>::Then then) const;
    Vec<D> end_of(LocalId i, double h) const;
    Suspect deepest(double h) const;
    double energy_growth(double h, int n, const StepStart<D>* start, EnergyLook look); // watch_energy.cpp
    template <class F>
    void for_each_work_of_walls(F&& f) const;
    double work_of_bonds(double h, int n, const StepStart<D>* start) const;
    Suspect driver() const;
    std::string cause(Watched what, double growth) const; // watch_causes.cpp
    std::string where() const;
    std::string place_of(GlobalId who) const;
    Suspect worst(const Suspect& mine) const;
    std::string named(const Suspect& suspect) const;
    Suspect least_solved() const;
    Suspect suspect(double measure, LocalId a, LocalId b) const;
    [[noreturn]] void fail(std::uint32_t flags, const PackFaults& faults, double h) const;
    std::uint32_t look_for_passages(double h, int n);
    [[noreturn]] void fail_of_passage(const std::string& where) const;
    [[noreturn]] void throw_through_wall(GlobalId who, const std::string& name, const std::string& where) const;

    const Communicator& comm_;
    Scene<D> scene_;
    Walls<D> walls_;
    Stopwatch watch_;
    mutable State<D> state_; ///< of it, `mid` alone follows when somebody asks for what a smooth step found
    Domain<D> domain_;
    ContactMemory<D> memory_; ///< of the impulses, across rebuilds
    // Between steps impulses stay in the batches; they are put back to their candidates when somebody asks.
    mutable CandidateSet<D> candidates_;
    mutable bool impulses_stale_ = false;
    mutable ContactsOf<D> contacts_;
    mutable bool records_stale_ = false;
    ContactSolver<D> solver_;
    ContactSums<D> sums_;
    EnergySums<D> energy_;
    bool energy_wanted_ = false;
    Counters counters_;
    Watcher watcher_;
    mutable Undo<D> undo_;

    /// What a look at all grains of a (sub)step found on this rank.
    struct Gauge {
        ExactSum grown;              ///< energy, kinetic and potential [J]
        ExactSum kinetic;            ///< at the start [J]
        double farthest_squared = 0; ///< of the ways from detection to the end [m²]
        bool finite = true;
        Suspect outside, deep;
    };
    Gauge gauge_;
    StepStart<D> start_;                  ///< of the step in hand, if it has several substeps
    int parts_ = 1, done_ = 0;            ///< substeps of the step in hand; of them, those taken
    bool intact_ = true;                  ///< false while lists are rebuilt
    bool predicted_ = false;              ///< u_old is of the step in hand
    bool shorter_ = false;                ///< the step is to be done again with more substeps
    bool memory_is_set_ = true;           ///< memory_ has the impulses of the next rebuild already
    std::int64_t unconverged_before_ = 0; ///< Counters::unconverged when the step began

    double r_max_ = 0, r_min_ = 0, mean_radius_ = 0, total_mass_ = 0, skin_ = 0;
    int stage_ = 0;
    double stage_start_ = 0;
    std::int64_t stage_steps_ = 0;
    std::int64_t stage_substeps_ = 0;
    bool rebuild_due_ = true;
    bool some_fast_ = false; ///< flag::fast of the substep before, of all ranks
    Passage passage_;        ///< this rank's, of the step in hand
    double impulse_h_ = 0;   ///< step [s] whose impulses the candidates hold: forces are kept where h changes
    std::uint32_t agreed_ = 0;
    std::vector<BodyVelocity<D>>
        correction_;            ///< displacements of the step over h; empty unless positions are corrected
    double lift_ = 0;           ///< potential energy that they cost [J]
    double steering_scale_ = 0; ///< V that tolerance and quiet tiles go by [m/s]
    /// Of Cundall's global damping, C h / 2m and C* h / 2I, for substeps of damping_h_ [s]; rows of grains held.
    struct Damping {
        double a = 0, of_spin = 0;
    };
    std::vector<Damping> damping_; ///< empty unless contacts are smooth
    double damping_h_ = 0;
    /// Of smooth steps: what may have happened since somebody looked.
    struct Bounds {
        double approached = 0;         ///< surfaces, since pairs nearer than `near` got their lanes [m]
        double near = 0;               ///< [m]
        double pace = 0;               ///< `approached` of the last step alone [m]
        double drifted = 0;            ///< any grain, since least_room was found [m]
        double least_room = 0;         ///< of any grain in its margin then [m]
        bool shallow = false;          ///< nothing is deep enough in anything to go through it
        std::optional<double> kinetic; ///< of grains owned, as the step begins [J]
        double weighed = 0;            ///< m |g| of grains owned times the mean radius of all [J]
    };
    Bounds bounds_;
    double pressed_h_ = 0;      ///< of the last smooth step [s]
    std::vector<double> gains_; ///< mechanical energy of each tile's grains, since the last correction [J]
    double correction_work_ = 0;
    std::optional<Residual> last_residual_;
    int last_sweeps_ = 0;

    std::vector<std::size_t> reported_tiles_; ///< see find_reported_tiles
    TileCosts<D> costs_;                      ///< since the last look at the balance
    double relaxing_ = 0;                     ///< seconds, since then
    std::int64_t last_balance_ = 0;           ///< step of the last look
    double rebuild_seconds_ = 0;              ///< of the last rebuild in which no tile moved
};

template <int D>
double smallest_radius(const Scene<D>& scene); ///< [m]

} // namespace nappe
