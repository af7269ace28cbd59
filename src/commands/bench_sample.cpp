#include "commands/bench_sample.hpp"

#include "commands/bench_memory.hpp"
#include "core/error.hpp"
#include "core/initial_grains.hpp"

#include <algorithm>
#include <optional>

namespace nappe {

namespace {

constexpr double height = 30;        // m
constexpr double area_per_disk = .9; // m², pores included, of radii 0.42-0.56 m as deposited
enum : int { floor_wall = 0, left_wall = 1, right_wall = 2 };

Stage stage_of(const char* name, int sweeps) {
    Stage stage;
    stage.name = name;
    stage.duration = 1; // binds nobody who counts steps
    stage.solver.h = 0.025;
    stage.solver.sweeps = sweeps;
    return stage;
}

} // namespace

Scene<2> bench_scene(double length) {
    Scene<2> scene;
    scene.title = "a settled block repeated";
    scene.gravity = {0, -9.81};
    scene.materials = {{"rock", 2800.0}};
    scene.laws = {{0, 0, bench_friction, 0.0}};
    Sample<2> sample;
    sample.radii = {RadiusLaw::Kind::uniform, 0.42, 0.56};
    sample.profile = {{0, 0}, {length, 0}, {length, height}, {0, height}};
    scene.sample = sample;
    scene.walls = {{"floor", 0, {{0, 0}, {length, 0}}, {}},
                   {"left", 0, {{0, 2 * height}, {0, 0}}, {}},
                   {"right", 0, {{length, 0}, {length, 2 * height}}, {}}};
    scene.stages = {stage_of("100 sweeps", 100), stage_of("10 sweeps", 10)};
    // A run looks at the balance every so many steps; a bench of a few steps has to look at once.
    scene.balance.every = 1;
    scene.balance.moves = BalanceSettings::Moves::always; // a few steps never pay for a move
    return scene;
}

namespace {

/// The box in which a block settles: side walls without friction (see repeat_block).
Scene<2> block_scene(double length, double friction) {
    auto scene = bench_scene(length);
    scene.laws[0].friction = friction;
    scene.materials.push_back({"smooth", 0.0});
    scene.laws.push_back({0, 1, 0.0, 0.0});
    scene.walls[left_wall].material = 1;
    scene.walls[right_wall].material = 1;
    return scene;
}

} // namespace

SettledBlock settle_block(const Communicator& alone, std::int64_t grains, int steps, double friction) {
    SettledBlock block;
    block.length = static_cast<double>(grains) * area_per_disk / height;
    Simulation<2> simulation(alone, block_scene(block.length, friction), disk_kernels());
    simulation.load(initial_grains(simulation.scene()), {}, simulation.settings().h);
    simulation.start_stage(static_cast<int>(BenchStage::sweeps_100));
    for (int k = 0; k < steps; ++k) {
        simulation.step();
    }
    block.grains = simulation.grain_rows();
    std::sort(block.grains.begin(), block.grains.end(), [](const auto& p, const auto& q) { return p.id < q.id; });
    block.impulses = simulation.contact_rows();
    return block;
}

std::int64_t n_copies(const SettledBlock& block, std::int64_t grains) {
    const auto n = static_cast<std::int64_t>(block.grains.size());
    return std::max<std::int64_t>(1, (grains + n / 2) / n);
}

namespace {

/// One copy of a block: its rows from the block's.
struct Copy {
    std::int64_t c = 0;
    std::int64_t n = 1; ///< copies in all
    GlobalId first_id = 0, next_id = 0;
    double length = 0; ///< of a block [m]

    bool mirrored() const { return c % 2 != 0; }

    GrainRow<2> grain(GrainRow<2> row) const {
        row.id += first_id;
        if (mirrored()) {
            row.x[0] = length - row.x[0];
            row.v[0] = -row.v[0];
            row.spin[0] = -row.spin[0];
            row.rotation[0] = -row.rotation[0];
        }
        row.x[0] += static_cast<double>(c) * length;
        return row;
    }

    /// @param wall that the contact is with, -1 between grains. Nothing for contacts that the copy before reports, and
    /// for an image of the left wall at the right end of the box: the next step finds those few anew.
    std::optional<ContactRow<2>> contact(ContactRow<2> row, int wall) const {
        const auto grain = row.lo;
        row.lo += first_id;
        row.r_t[0] = mirrored() ? -row.r_t[0] : row.r_t[0];
        if (wall < 0) {
            row.hi += first_id;
        } else if (wall != floor_wall) {
            const bool to_the_right = (wall == right_wall) != mirrored();
            if (to_the_right && c + 1 < n) {
                row.hi = grain + next_id;
            } else if (mirrored() || (!to_the_right && c > 0)) {
                return std::nullopt;
            }
        }
        return row;
    }
};

} // namespace

BenchSample repeat_block(const SettledBlock& block, std::int64_t first, std::int64_t last, std::int64_t n) {
    BenchSample sample;
    sample.grains.reserve(static_cast<std::size_t>(last - first) * block.grains.size());
    sample.impulses.reserve(static_cast<std::size_t>(last - first) * block.impulses.size());
    const Walls<2> walls(bench_scene(block.length).walls); // a longer box has the same features in the same order
    const auto per_copy = static_cast<GlobalId>(block.grains.size());
    for (auto c = first; c < last; ++c) {
        const Copy copy{c, n, c * per_copy, (c + 1) * per_copy, block.length};
        for (const auto& row : block.grains) {
            sample.grains.push_back(copy.grain(row));
        }
        for (const auto& row : block.impulses) {
            const int wall = row.hi < wall_key ? -1 : walls.feature(static_cast<int>(row.hi - wall_key)).wall;
            if (const auto copied = copy.contact(row, wall)) {
                sample.impulses.push_back(*copied);
            }
        }
    }
    return sample;
}

void load_copies(Simulation<2>& simulation, const SettledBlock& block, std::int64_t n) {
    const auto& comm = simulation.comm();
    const auto stage = static_cast<int>(BenchStage::sweeps_100);
    {
        const auto share = repeat_block(block, n * comm.rank() / comm.size(), n * (comm.rank() + 1) / comm.size(), n);
        simulation.load(share.grains, share.impulses, simulation.scene().stages[stage].solver.h);
    }
    return_free_memory();
    simulation.start_stage(stage);
}

void on_root_alone(const Communicator& comm, const std::function<void()>& work) {
    std::string error;
    if (comm.is_root()) {
        try {
            work();
        } catch (const NumericalFailure& e) {
            error = e.what();
        }
    }
    comm.sleepy_barrier();
    comm.throw_together<NumericalFailure>(error);
}

} // namespace nappe
