#pragma once
// The contact problem of one step for disks: from frozen candidates, those that may act in this step, packed for the
// sweep.

#include "core/contact_set.hpp"
#include "core/state.hpp"
#include "core/walls.hpp"
#include "solver/contact_reports.hpp"
#include "solver/disk_batch.hpp"
#include "solver/pair_laws.hpp"

#include <array>
#include <vector>

namespace nappe {

inline constexpr std::size_t no_tile = static_cast<std::size_t>(-1);

/// Batches stay from step to step: as long as no contact comes to act that has no lane, a tile only gets new normals and
/// biases, and contacts that fall asleep keep their lanes, without effect. Else the tile is packed anew: each contact
/// goes, in frozen order, into the first batch with a free lane after all those that its grains are in. Contacts that
/// share no grain commute to the bit, so this fills batches and changes nothing.
class DiskContacts {
public:
    DiskContacts(const Scene<2>& scene, const DiskKernels& kernels) : laws_(scene), kernels_(&kernels) {}

    /// Local. From now on, with the law's cohesion or without; to be followed by `forget`.
    void set_cohesive(bool cohesive) { cohesive_ = cohesive && laws_.features.cohesion; }
    bool cohesive() const { return cohesive_; }

    /// Local. For how many substeps normals are to serve: with more than one, gaps are kept with the contacts, and who may
    /// act is looked for that far ahead. They are kept also if positions are to be corrected. To be followed by `forget`.
    void set_kept(int substeps, bool correcting) {
        kept_ = substeps;
        keeps_gaps_ = substeps > 1 || correcting || smooth_;
    }

    /// Local. Springs and dashpots from now on; to be followed by `set_kept`.
    void set_smooth(bool smooth) { smooth_ = smooth; }

    // Smooth contacts (disk_pressing.cpp): lanes hold all pairs that may overlap until surfaces may have come nearer by
    // `near`, a step is one pass over them, and what it does not store is found again when somebody asks.
    /// Local. Gives lanes to all pairs nearer than `near` [m], with their springs, and to those nearer than twice that in
    /// tiles where one had none. Pre: as for `pack`.
    PackFaults gather_near(const State<2>& state, CandidateSet<2>& candidates, const Walls<2>& walls, double h,
                           double near);
    bool uniform_springs() const { return laws_.uniform_springs; } ///< SmoothStep::uniform
    bool fresh() const { return fresh_; }                          ///< gather_near has to be called
    /// Local. Cundall's forces of one tile (DiskKernels::press). @param faults of its contacts with walls are added
    SmoothTally press(std::size_t tile, const State<2>& state, const CandidateSet<2>& candidates, const Walls<2>& walls,
                      const SmoothStep& step, PackFaults& faults);
    /// Local. After all tiles: springs are those of the step's end, or, if it has failed, of its start again.
    void swap_springs() { tangent_.swap(tangent_after_); }
    /// Local. What the last step found and did not store, and the largest overlap, over the smaller radius.
    void record(const State<2>& state, double h);

    /// Local. Prepares the correction of positions after a step of h that ends at velocities u (DiskKernels), and one of
    /// its passes over a tile, which changes velocities w.
    void begin_correction(const std::vector<BodyVelocity<2>>& u, double h, double share);
    void relax_correction(std::size_t tile, std::size_t next, std::vector<BodyVelocity<2>>& w);

    /// Local. Gaps and biases after a substep of h at velocities u, normals as they are; its impulses are added up.
    void advance(const std::vector<BodyVelocity<2>>& u, double h);

    /// Local. Which pairs are bonded, from their gaps at State::mid and Walls::offset_mid, which are to be the positions
    /// at the start of the step: fills candidates.bond. Pre: cohesive().
    void find_bonds(const State<2>& state, CandidateSet<2>& candidates, const Walls<2>& walls);

    /// Local. Candidates are new, or their impulses: the next `pack` takes both.
    void forget() { fresh_ = true; }

    /// Local. Geometry of every candidate at the predicted positions; those that may act in a step of h are packed, the
    /// first time with their impulses from `candidates`, later with those that the batches hold, which are stored there
    /// first. Who may act: a gap below what the pair could close at twice its present speed of approach, plus 1 % of the
    /// radii; the others sleep.
    /// `activate_all` packs every candidate. Pre: u is the free velocity, u_old that of the step's start; `candidates`
    /// are those of the last call, or `forget` was called; with cohesion their bonds are those of this step, and what is
    /// bonded acts whatever its gap.
    PackFaults pack(const State<2>& state, CandidateSet<2>& candidates, const Walls<2>& walls, double h,
                    bool activate_all);

    /// Local. Whether a candidate that sleeps would have had to act, at velocities u: then the step must be redone.
    bool missed_any(const State<2>& state, const CandidateSet<2>& candidates, const Walls<2>& walls, double h);

    /// Local. One pass over a tile; `next` is the tile after it, whose bodies are fetched meanwhile, or no_tile.
    void relax(std::size_t tile, std::size_t next, std::vector<BodyVelocity<2>>& u) {
        kernels_->relax(span(ranges_[tile]), u.data()->v.data(), bodies_of(next));
    }

    /// Local. Room for what a method keeps of each impulse from sweep to sweep: `n` numbers, 2 at most; the first is the
    /// impulse now, the second 0.
    void remember(int n);

    // Local. One tile's part in the passes of the methods (DiskKernels says what they do).
    double relax_watched(std::size_t tile, std::size_t next, std::vector<BodyVelocity<2>>& u);
    StepSums relax_ahead(std::size_t tile, std::size_t next, double beta, const TermRounding& rounding,
                         std::vector<BodyVelocity<2>>& u);
    StepSums relax_along(std::size_t tile, std::size_t next, double beta, const TermRounding& rounding,
                         std::vector<BodyVelocity<2>>& u);
    StepSums project(std::size_t tile, double beta, double step, const TermRounding& rounding,
                     const std::vector<BodyVelocity<2>>& at, std::vector<BodyVelocity<2>>& u);
    StepSums gradient(std::size_t tile, const TermRounding& rounding, const std::vector<BodyVelocity<2>>& at,
                      std::vector<BodyVelocity<2>>& of_z);
    StepSums turn(std::size_t tile, double beta, const TermRounding& rounding, const std::vector<BodyVelocity<2>>& at,
                  std::vector<BodyVelocity<2>>& of_p);
    void go_along(std::size_t tile, double alpha, std::vector<BodyVelocity<2>>& u);

    /// Local. Copies of all batches in single precision, for relax_single.
    void round_batches();
    void relax_single(std::size_t tile, std::size_t next, std::vector<BodyVelocity<2, float>>& u);
    /// Local. The impulses of a tile's copies become its own, u follows.
    void settle_single(std::size_t tile, std::vector<BodyVelocity<2>>& u);
    std::size_t bytes_swept_single() const; ///< by one sweep in single precision, without bodies

    void apply(std::size_t tile, std::vector<BodyVelocity<2>>& u) {
        kernels_->apply(span(ranges_[tile]), u.data()->v.data());
    }

    /// Local. One tile's residual at velocities u.
    RawResidual residual(std::size_t tile, const std::vector<BodyVelocity<2>>& u) const;

    /// Local. Sum of squared relative velocities over one tile's touching contacts [m²/s²] and their number.
    std::pair<double, std::int64_t> touching_speed(std::size_t tile, const std::vector<BodyVelocity<2>>& u) const;

    /// Local. All impulses become 0.
    void start_cold();

    /// Local. Puts the impulses back to their candidates; those that sleep have none.
    void store(CandidateSet<2>& candidates) const;

    /// Local. Sweeps with another instruction set from now on: the packed contacts are the same for all.
    void use(const DiskKernels& kernels) { kernels_ = &kernels; }

    /// Largest overlap that the last `pack` met on this rank, over the smaller radius.
    double deepest() const { return deepest_; }

    /// Calls f(a, b, n, gamma h) for the contacts of a tile that attract, in the order of candidates. Pre: cohesive().
    template <class F>
    void for_each_bond(std::size_t tile, F&& f) const {
        for_each_lane(tile, [&](const DiskBatch& batch, std::int64_t k, int l) {
            if (const double most = cohesion_[static_cast<std::size_t>(k)].most[l]; most > 0) {
                f(row(batch.a[l]), row(batch.b[l]), Vec<2>(batch.nx[l], batch.ny[l]), most);
            }
        });
    }

    /// Calls f(a, b, squared residual) for the packed contacts of a tile, in the order of candidates.
    template <class F>
    void for_each_residual(std::size_t tile, const std::vector<BodyVelocity<2>>& u, F&& f) const {
        for_each_lane(tile, [&](const DiskBatch& batch, std::int64_t k, int l) {
            f(row(batch.a[l]), row(batch.b[l]), squared_residual(batch, k, l, u));
        });
    }

    /// Of the contacts that this rank counts.
    std::int64_t n_active() const { return n_active_ - (n_counted_ < ranges_.size() ? ranges_.back().active : 0); }
    /// Calls f(a, wall body, n, r_n, r_t) for the contacts of a tile with walls, as for_each_summed would.
    template <class F>
    void for_each_of_walls(std::size_t tile, F&& f) const {
        const Range& range = ranges_[tile];
        for (auto w = range.walls_begin; w < range.walls_begin + range.n_walls; ++w) {
            const std::int64_t slot = walls_[static_cast<std::size_t>(w)].slot;
            if (slot < 0) {
                continue;
            }
            const DiskBatch& batch = batches_[static_cast<std::size_t>(slot / n_lanes)];
            if (const auto l = static_cast<int>(slot % n_lanes); batch.m_eff[l] > 0) {
                const auto r = summed(batch, slot / n_lanes, l);
                f(row(batch.a[l]), row(batch.b[l]), Vec<2>(batch.nx[l], batch.ny[l]), r.n, r.t[0]);
            }
        }
    }

    std::int64_t n_active(std::size_t tile) const { return ranges_[tile].active; }
    std::int64_t n_batches(std::size_t tile) const { return ranges_[tile].n; }
    std::size_t n_tiles() const { return ranges_.size(); }
    std::size_t n_counted_tiles() const { return n_counted_; } ///< CandidateSet::counted_tiles
    StepSums counted(std::size_t tile, const StepSums& sums) const { return tile < n_counted_ ? sums : StepSums{}; }

    /// Calls f(a, b, n, impulse) for the packed contacts of a tile, in the order of candidates.
    template <class F>
    void for_each(std::size_t tile, F&& f) const {
        for_each_lane(tile, [&](const DiskBatch& batch, std::int64_t k, int l) {
            f(row(batch.a[l]), row(batch.b[l]), Vec<2>(batch.nx[l], batch.ny[l]), batch.r_n[l], tangential(k, l));
        });
    }

    /// The same with impulses summed over the substeps since `pack`, the one in hand included.
    template <class F>
    void for_each_summed(std::size_t tile, F&& f) const {
        for_each_lane(tile, [&](const DiskBatch& batch, std::int64_t k, int l) {
            const auto r = summed(batch, k, l);
            f(row(batch.a[l]), row(batch.b[l]), Vec<2>(batch.nx[l], batch.ny[l]), r.n, r.t[0]);
        });
    }

    /// Calls f(a, b, n, impulse, s h, s h of the step before) with the tangential springs s of smooth contacts, likewise.
    template <class F>
    void for_each_spring(std::size_t tile, F&& f) const {
        for_each_lane(tile, [&](const DiskBatch& batch, std::int64_t k, int l) {
            const double before = tangent_after_.empty() ? 0.0 : tangent_after_[static_cast<std::size_t>(k)].r_t[l];
            f(row(batch.a[l]), row(batch.b[l]), Vec<2>(batch.nx[l], batch.ny[l]), summed(batch, k, l), tangential(k, l),
              before);
        });
    }

    /// Calls f(name, array) for every array over lanes, which has an element for each or for each batch, and over
    /// candidates.
    template <class F>
    void for_each_array(F&& f) const {
        f("batches", batches_);
        f("source", source_);
        f("tangent", tangent_);
        f("friction", friction_);
        f("cohesion", cohesion_);
        f("asleep", asleep_);
        f("kept_gaps", kept_gaps_);
        f("summed", summed_);
        f("corrections", corrections_);
        f("memory[0]", memory_[0]);
        f("memory[1]", memory_[1]);
        f("single", single_);
        f("springs", springs_);
        f("tangent_after", tangent_after_);
    }

    std::size_t bytes_swept() const; ///< by one sweep, without bodies
    const DiskKernels& kernels() const { return *kernels_; }
    const char* instruction_set() const { return kernels_->name; }

private:
    struct Range {
        std::int64_t begin = 0;  ///< first batch
        std::int64_t n = 0;      ///< batches in use
        std::int64_t room = 0;   ///< batches that belong to the tile
        std::int64_t packed = 0; ///< contacts with a lane
        std::int64_t active = 0; ///< of them, those that do not sleep
        std::int32_t candidates_begin = 0, n_candidates = 0;
        mutable bool others_are_zero = false;      ///< candidates without a lane have no impulse stored
        BodyRange bodies;                          ///< the tile's own
        std::int32_t asleep = 0;                   ///< entries of asleep_ from candidates_begin on
        std::int32_t walls_begin = 0, n_walls = 0; ///< entries of walls_
    };

    /// Room for contacts that come to act in a tile before the next rebuild.
    static constexpr std::int64_t spare_batches = 2;

    /// A candidate with a wall: wall geometry is not the kernels'.
    struct WallPair {
        std::int32_t candidate = 0;
        bool asleep = false;
        std::int64_t slot = -1; ///< lane among all lanes, -1: not packed
    };

    /// What a step finds of one candidate.
    enum class Decision { ignore, sleep, act };
    struct Found {
        Decision decision = Decision::ignore;
        Vec<2> n = Vec<2>::Zero();
        double bias = 0;
        double gap = 0;
    };

    struct Step { ///< what all of `pack` reads
        const State<2>& state;
        const CandidateSet<2>& candidates;
        const Walls<2>& walls;
        double h;
        double look; ///< seconds ahead that the rule of who may act looks
        bool activate_all;
        BodyArrays bodies;
    };

    void meet_walls(const Range& range, const Step& step, PackFaults& faults);
    static BodyArrays arrays(const State<2>& state) {
        return {state.mid.data()->x.data(), state.u.data()->v.data(), state.u_old.data()->v.data()};
    }
    static double* doubles(std::vector<BodyVelocity<2>>& u) { return u.data()->v.data(); }
    static const double* doubles(const std::vector<BodyVelocity<2>>& u) { return u.data()->v.data(); }
    BodyRange bodies_of(std::size_t tile) const { return tile == no_tile ? BodyRange{} : ranges_[tile].bodies; }
    SearchBatch* memory(std::size_t which, std::size_t tile) { return memory_[which].data() + ranges_[tile].begin; }
    SingleBatch* single_of(std::size_t tile) { return single_.data() + ranges_[tile].begin; }
    BatchSpan span(const Range& range) {
        const auto from = [&](auto& side) { return side.empty() ? nullptr : side.data() + range.begin; };
        return {batches_.data() + range.begin, range.n,          from(tangent_), from(friction_), from(cohesion_),
                laws_.uniform_friction,        from(kept_gaps_), from(summed_)};
    }
    /// The tangential impulse of a lane [N s].
    double tangential(std::int64_t batch, std::int64_t l) const {
        return tangent_.empty() ? 0.0 : tangent_[static_cast<std::size_t>(batch)].r_t[l];
    }
    /// The impulses of a lane, with those of the substeps before that had its normal [N s].
    Impulse<2> summed(const DiskBatch& batch, std::int64_t k, int l) const {
        Impulse<2> r{batch.r_n[l], {tangential(k, l)}};
        if (!summed_.empty()) {
            r.n += summed_[static_cast<std::size_t>(k)].n[l];
            r.t[0] += summed_[static_cast<std::size_t>(k)].t[l];
        }
        return r;
    }
    double squared_residual(const DiskBatch& batch, std::int64_t k, int l,
                            const std::vector<BodyVelocity<2>>& u) const; // [m²/s²]
    void set_tangential(std::int64_t batch, std::int64_t l, double r_t) {
        if (!tangent_.empty()) {
            tangent_[static_cast<std::size_t>(batch)].r_t[l] = r_t;
        }
    }
    void keep_gap(std::int64_t slot, double gap) {
        if (!kept_gaps_.empty()) {
            kept_gaps_[static_cast<std::size_t>(slot / n_lanes)].gap[slot % n_lanes] = gap;
        }
    }
    static LocalId row(std::uint32_t index) { return static_cast<LocalId>(index / 4); }

    /// Contacts that do not sleep, in the order of candidates: lanes are where there was room, which depends on what the
    /// tile and its neighbours in storage have been through, and sums must not.
    template <class F>
    void for_each_lane(std::size_t tile, F&& f) const {
        const Range& range = ranges_[tile];
        lane_of_.assign(static_cast<std::size_t>(range.n_candidates), -1);
        for (auto slot = range.begin * n_lanes; slot < (range.begin + range.n) * n_lanes; ++slot) {
            const std::int32_t c = source_[static_cast<std::size_t>(slot)];
            if (c >= 0) {
                lane_of_[static_cast<std::size_t>(c - range.candidates_begin)] = slot;
            }
        }
        for (const std::int64_t slot : lane_of_) {
            if (slot >= 0 && batches_[static_cast<std::size_t>(slot / n_lanes)].m_eff[slot % n_lanes] > 0) {
                f(batches_[static_cast<std::size_t>(slot / n_lanes)], slot / n_lanes, static_cast<int>(slot % n_lanes));
            }
        }
    }

    /// Normals serve for several substeps, or tangential forces have a part that no spring remembers.
    bool sums() const { return kept_ > 1 || smooth_; }

    void lay_out(const Step& step);
    void refresh_bonds(const Range& range, const Step& step);
    void refresh_bond(std::int64_t slot, const Step& step, std::int32_t c);
    bool refresh_tile(std::size_t tile, const Step& step, PackFaults& faults);
    void pack_all(const Step& step, PackFaults& faults);
    bool pack_tile(std::size_t tile, const Step& step, PackFaults& faults);
    bool missed_in_lanes(const Range& range, const State<2>& state, const Walls<2>& walls, double h) const;
    bool any_wakes(std::size_t tile, const Step& step);
    bool bonded(const Step& step, std::int32_t c) const {
        return cohesive_ && step.candidates.bond[static_cast<std::size_t>(c)] != Bond::none;
    }
    bool may_rest(double gap, double size, double v_free, double v_old, double look, double near) const;
    Found judge(const Step& step, std::int32_t c, const Vec<2>& n, double gap, double size, double v_free,
                double v_old) const;
    Found judge_wall(const Step& step, std::int32_t c, PackFaults& faults);
    void note_overlap(double gap, double r_a, double r_b) {
        const double overlap = -gap / (r_a < r_b ? r_a : r_b);
        deepest_ = overlap > deepest_ ? overlap : deepest_;
    }
    std::int64_t place(Range& range, const Step& step, std::int32_t c, const Found& found);
    void set_springs(std::int64_t batch, int l, int material_a, int material_b);
    void grow(Range& range, std::int64_t n);
    void clear(std::int64_t at, LocalId null_body);
    void measure(const std::int32_t* which, std::int32_t n, const CandidateSet<2>& candidates, std::int32_t from,
                 const BodyArrays& bodies);
    void store_tile(std::size_t tile, CandidateSet<2>& candidates) const;

    PairLaws laws_;
    const DiskKernels* kernels_;
    std::vector<DiskBatch> batches_;
    std::vector<TangentBatch> tangent_;              ///< empty without friction
    std::vector<FrictionBatch> friction_;            ///< empty unless laws differ in it
    std::vector<CohesionBatch> cohesion_;            ///< empty unless cohesive_
    std::array<std::vector<SearchBatch>, 2> memory_; ///< empty unless a method asked for it
    std::vector<KeptGapBatch> kept_gaps_;            ///< empty unless keeps_gaps_
    std::vector<SearchBatch> summed_;                ///< empty unless sums()
    std::vector<DiskBatch> corrections_;             ///< empty unless positions are corrected
    std::vector<SingleBatch> single_;                ///< empty unless swept over in single precision
    std::vector<SpringBatch> springs_;               ///< empty unless smooth_
    std::vector<TangentBatch> tangent_after_;        ///< likewise, or without friction
    bool smooth_ = false;
    double near_ = 0; ///< of the last gather_near [m]
    bool keeps_gaps_ = false;
    int kept_ = 1; ///< substeps that normals serve for
    bool cohesive_ = false;
    std::vector<std::int32_t> source_; ///< candidate of every lane, -1 for null contacts
    std::vector<Range> ranges_;        ///< of every tile
    std::size_t n_counted_ = 0;        ///< of them, those that this rank counts
    std::vector<std::int32_t> asleep_; ///< candidates of disks that sleep, by tile
    std::vector<WallPair> walls_;      ///< by tile
    std::int64_t n_active_ = 0;
    double deepest_ = 0;
    bool fresh_ = true;

    mutable std::vector<std::int64_t> lane_of_; ///< scratch of for_each_lane
    std::vector<unsigned char> of_walls_;       ///< of `press`: which batches of a tile have lanes of walls, else 0
    std::vector<GapBatch> gaps_;                ///< of one tile
    std::vector<std::int32_t> last_;  ///< by row: the latest batch that has the grain, counted over all tiles packed
    std::int32_t n_packed_ = 1;       ///< that count before the tile in hand
    std::vector<std::int8_t> filled_; ///< lanes in use of the tile's batches
    std::size_t first_open_ = 0;      ///< batches before it are full
};

} // namespace nappe
