// The means of trading speed for accuracy: what each must leave as it is, and what it must change.

#include "core/error.hpp"
#include "support/serial_run.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace nappe::test::trading_test {
namespace {

constexpr double g = standard_gravity;

double energy_of(SerialRun& run) {
    double sum = 0;
    for (const auto& row : run.simulation().grain_rows()) {
        const double rim = row.radius * row.spin[0];
        sum += row.mass * (0.5 * (row.v[0] * row.v[0] + row.v[1] * row.v[1] + 0.5 * rim * rim) + g * row.x[1]);
    }
    return sum;
}

/// A deposit that falls together, beside a wall that stands.
SceneBuilder falling_deposit(double friction = 0.4) {
    SceneBuilder b(friction);
    b.box(8, 4, {RadiusLaw::Kind::uniform, 0.15, 0.25});
    return b;
}

/// Disks that fall on top of each other in a line keep their normals: then substeps with the geometry of the first are
/// the same, up to round-off of gaps (1e-16 m, over h).
TEST(KeptGeometry, ChangesNothingWhereNormalsStay) {
    const auto heights = [](int every) {
        auto settings = solver(0.02, 400);
        settings.substeps = 8;
        settings.geometry_every = every;
        SceneBuilder b(0.3);
        b.floor();
        for (int k = 0; k < 5; ++k) {
            b.grain(0.5, {0, 0.5 + 1.03 * k}, {0, -0.2 * k});
        }
        b.stage(settings);
        SerialRun run(b.scene());
        run.steps(30);
        std::vector<double> y;
        for (int k = 0; k < 5; ++k) {
            y.push_back(run.grain(k).x[1]);
        }
        return y;
    };
    const auto own = heights(1), kept = heights(8), some = heights(3);
    for (std::size_t k = 0; k < own.size(); ++k) {
        EXPECT_NEAR(kept[k], own[k], 1e-10) << k;
        EXPECT_NEAR(some[k], own[k], 1e-10) << k;
    }
    EXPECT_NEAR(own[4], 4.5, 0.05) << "they came down";
}

/// A disk rolls down the inside of a corner: where normals turn, they are renewed once a step, and the step's length bounds
/// the error. Energy does not grow, the disk ends in the corner, in whatever parts the step is done.
TEST(KeptGeometry, NormalsAreRenewedEveryStep) {
    for (const int every : {1, 4}) {
        auto settings = solver(0.01, 40);
        settings.substeps = 4;
        settings.geometry_every = every;
        SceneBuilder b(0.2);
        b.floor().grain(0.5, {0, 0.5}).grain(0.5, {1.05, 0.5}).grain(0.4, {0.45, 1.5}).stage(settings);
        SerialRun run(b.scene());
        const double before = energy_of(run);
        run.steps(300);
        EXPECT_LE(energy_of(run), before) << every;
        EXPECT_NEAR(run.grain(2).x[1], 0.4, 0.01) << every << ": pressed its way to the floor";
        EXPECT_LT(run.grain(0).x[0], -0.1) << every;
    }
}

/// A group that is done again, since a contact that was left out came to act, starts as it was: positions, velocities, and
/// where bonds are looked for. Then it is what substeps with a geometry of their own are, up to the impulses that sweeps start from.
TEST(KeptGeometry, ARedoneGroupStartsAsItWas) {
    const auto run_of = [](int every) {
        auto settings = solver(0.01, 1000);
        settings.substeps = 10;
        settings.geometry_every = every;
        SceneBuilder b(0);
        b.gravity(0, 0)
            .cohesion(0, 0, 1e6, 0.005)
            .grain(0.5, {-0.08, 0}, {8, 0}); // 0.04 m from the second after a step
        b.grain(0.5, {1.04, 0}).grain(0.5, {2.0605, 0}).stage(settings);
        b.scene().tiles.side = 40;
        b.scene().tiles.skin = 1; // no new lists, which would take bonds from where all started
        SerialRun run(b.scene());
        run.steps(2);
        std::vector<double> found;
        for (int k = 0; k < 3; ++k) {
            found.insert(found.end(), {run.grain(k).x[0], run.grain(k).v[0]});
        }
        return std::pair(found, run.simulation().counters().redone_groups);
    };
    const auto own = run_of(1), kept = run_of(10);
    EXPECT_EQ(kept.second, 1);
    for (std::size_t k = 0; k < own.first.size(); ++k) {
        EXPECT_NEAR(kept.first[k], own.first[k], 1e-9 * 8) << k; // round-off of gaps over h, ten times
    }
}

/// Where something moves more than 1/16 of its radius in a substep (31 m/s here), all have normals of their own: the same
/// bits. One grain that is fast all along, one that gets fast and slides off a wall's end in one group, one that is fast no
/// longer after its first.
TEST(KeptGeometry, FastGrainsHaveNormalsOfTheirOwn) {
    struct Meeting {
        double gravity, speed;
        Vec<2> other;
    };
    for (const Meeting& m : {Meeting{0, 50, {2, 0.9}}, {1000, 0, {0, 5}}, {0, 35, {1, 0.5}}}) {
        const auto hash = [&](int every) {
            auto settings = solver(0.01, 100);
            settings.substeps = 10;
            settings.geometry_every = every;
            SceneBuilder b(0);
            b.gravity(m.gravity, 0).grain(0.5, {0, 0}, {m.speed, 0}).grain(0.5, m.other);
            if (m.gravity > 0) {
                b.wall("post", {{1, 0.3}, {3, 0.3}}); // met after 0.6 m, in the fourth step
            }
            b.scene().tiles.side = 40;
            b.scene().tiles.skin = 2; // lists last
            SerialRun run(b.stage(settings).scene());
            run.steps(4);
            return run.simulation().state_hash();
        };
        EXPECT_EQ(hash(10), hash(1)) << m.speed;
    }
}

/// What a floor and a moving wall gave is reported whole, whatever shares a geometry: the grains' momentum changes by it and
/// by gravity's, and their energy by the walls' work less what contacts took, which is at least 0.
TEST(KeptGeometry, AllSubstepsAreReported) {
    for (const int every : {1, 5}) {
        auto b = falling_deposit();
        b.scene().walls[1].motion = Motion<2>{{0.3, 0}, 0, 0, {}};
        auto settings = solver(0.01, 50);
        settings.substeps = 5;
        settings.geometry_every = every;
        SerialRun run(b.stage(settings).scene());
        run.steps(3);
        const auto momentum = [&] {
            Vec<2> sum = Vec<2>::Zero();
            for (const auto& row : run.simulation().grain_rows()) {
                sum += row.mass * Vec<2>(row.v[0], row.v[1]);
            }
            return sum;
        };
        auto& sums = run.simulation().sums();
        sums.clear();
        const auto before = momentum();
        const double energy = energy_of(run);
        run.steps(40);
        EXPECT_EQ(sums.n_steps(), 40 * 5) << every;
        Vec<2> given(0, -run.simulation().total_mass() * g * 40 * settings.h);
        for (int w = 0; w < run.simulation().walls().n_walls(); ++w) {
            given -= sums.wall_impulse(static_cast<std::size_t>(w)); // that is of grains on walls
        }
        const double scale = run.simulation().total_mass() * g * 40 * settings.h;
        EXPECT_LT((momentum() - before - given).norm(), 1e-10 * scale) << every; // round-off of 200 substeps
        EXPECT_GT(given.norm(), 0.01 * scale) << "nothing was hit";
        EXPECT_LT(energy_of(run), energy + sums.wall_work()) << every;
        EXPECT_GT(sums.wall_work(), 0) << every;
    }
}

/// A tile that is left alone only while nothing at all changes leaves every bit as it was.
TEST(Adaptive, NoToleranceNoDifference) {
    const auto run_of = [](std::optional<double> adaptive) {
        auto b = falling_deposit();
        auto settings = solver(0.005, 30);
        settings.adaptive = adaptive;
        SerialRun run(b.stage(settings).scene());
        run.steps(60);
        return std::pair(run.simulation().state_hash(), run.simulation().counters().relaxations);
    };
    const auto all = run_of({}), strict = run_of(1e-30), loose = run_of(1e-2);
    EXPECT_EQ(strict.first, all.first);
    EXPECT_LE(strict.second, all.second);
    EXPECT_NE(loose.first, all.first) << "nothing was skipped: the case is too easy";
    EXPECT_LT(loose.second, all.second);
}

/// A pile at rest beside nothing that moves is left alone after a sweep or two, and still carries its weight: what a skipped
/// contact lacks is adaptive V in velocity, a few layers deep.
TEST(Adaptive, RestIsCheapAndStillCarries) {
    auto b = falling_deposit();
    auto settings = solver(0.005, 100);
    b.stage(settings);
    settings.adaptive = 1e-3;
    SerialRun run(b.stage(settings).scene());
    run.steps(800);
    const auto before = run.simulation().counters().relaxations;
    run.steps(100);
    const auto in_full = run.simulation().counters().relaxations - before;
    run.simulation().start_stage(1);
    run.steps(100);
    EXPECT_LT(10 * (run.simulation().counters().relaxations - before - in_full), in_full);
    double up = 0;
    for (const auto& row : run.loaded_contacts()) {
        up += row.wall >= 0 ? row.r_n * row.normal[1] + row.r_t[0] * row.normal[0] : 0;
    }
    const double weight = run.simulation().total_mass() * g * settings.h;
    EXPECT_NEAR(up, weight, 0.01 * weight) << "20 layers times 1e-3 would be 2 %, and they do not all err one way";
}

/// What wakes a tile is its surroundings: a disk dropped onto a quiet pile is felt below.
TEST(Adaptive, AnImpactWakesWhatIsBelow) {
    auto b = falling_deposit();
    auto settings = solver(0.005, 100);
    settings.adaptive = 1e-3;
    b.grain(0.3, {4, 12});
    SerialRun run(b.stage(settings).scene());
    const auto bounce = static_cast<std::int64_t>(std::sqrt(2 * 7.5 / g) / settings.h); // it falls 7.5 m and more
    double quiet = 0, loud = 0;
    for (std::int64_t k = 0; k < 2 * bounce; ++k) {
        const auto before = run.simulation().counters().relaxations;
        run.steps(1);
        const auto now = static_cast<double>(run.simulation().counters().relaxations - before);
        (k < bounce && k > bounce / 2 ? quiet : loud) = std::max(k < bounce && k > bounce / 2 ? 0.0 : loud, now);
    }
    EXPECT_GT(loud, 2 * quiet);
    EXPECT_GT(run.grain(static_cast<GlobalId>(run.simulation().domain().n_grains()) - 1).x[1], 2)
        << "it lies on the pile";
}

/// The correction of positions moves grains only as far as contacts have dissipated: without it the step would have lost at
/// least what it lifts. (A step of so few sweeps may give energy back, as an elastic body does; then nothing is lifted.)
TEST(PositionCorrection, PutsNoEnergyIn) {
    for (const auto& [share, substeps] : {std::pair(0.0, 1), std::pair(0.3, 1), std::pair(0.8, 5)}) {
        auto b = falling_deposit();
        auto settings = solver(0.02, 60); // too few for its layers: overlaps
        settings.position_correction = share;
        settings.substeps = settings.geometry_every = substeps;
        SerialRun run(b.stage(settings).scene());
        const double scale = 8 * 4 * 0.83 * 2800 * g * 4; // of all energies [J]
        double before = energy_of(run), lifted_before = 0;
        int limited = 0;
        for (int k = 0; k < 300; ++k) {
            run.steps(1);
            const double now = energy_of(run), lifted = run.simulation().correction_work() - lifted_before;
            const double lost = -(now - before - lifted);                           // by contacts
            EXPECT_LE(lifted, std::max(lost, 0.0) + 1e-12 * scale) << "step " << k; // round-off of sums of energies
            limited += lifted > 0 && lifted > 0.999 * lost ? 1 : 0;
            before = now;
            lifted_before += lifted;
        }
        EXPECT_EQ(limited > 0, share > 0) << "the bound never acted: the case is too easy";
    }
}

/// Where walls do work there is enough to pay with, and overlaps shrink.
TEST(PositionCorrection, OverlapsShrink) {
    const auto overlap_with = [](double share) {
        auto b = falling_deposit();
        b.scene().walls[1].motion = Motion<2>{{0.3, 0}, 0, 0, {}};
        auto settings = solver(0.01, 60);
        settings.position_correction = share;
        SerialRun run(b.stage(settings).scene());
        run.steps(300);
        return overlaps(run.simulation()).mean;
    };
    EXPECT_LT(2 * overlap_with(0.3), overlap_with(0));
}

/// Grains may be moved apart farther than lists foresaw, by nothing that their velocities tell: lists are made anew for it.
TEST(PositionCorrection, MayOutrunTheLists) {
    for (const int substeps : {1, 3}) {
        auto settings = solver(0.01, 30);
        settings.position_correction = 1;
        settings.substeps = settings.geometry_every = substeps;
        SceneBuilder b(0);
        b.gravity(0, 0).grain(0.5, {0, 0}).grain(0.5, {0.8, 0}).stage(settings); // at rest, 0.2 m in each other
        b.scene().tiles.skin = 1e-3;
        SerialRun run(b.scene());
        run.steps(1);
        EXPECT_GT(run.simulation().counters().redone_lists, 0) << substeps;
        EXPECT_NEAR(run.grain(1).x[0] - run.grain(0).x[0], 1, 1e-12) << substeps;
        EXPECT_EQ(run.grain(0).v[0], 0) << substeps;
    }
}

/// Without anything dissipated nothing is paid for: a disk that rests in the floor stays there.
TEST(PositionCorrection, NothingIsLiftedForFree) {
    auto settings = solver(0.01, 10);
    settings.position_correction = 1;
    SceneBuilder b(0);
    b.floor().grain(0.5, {0, 0.49}).stage(settings); // 0.01 m in the floor
    SerialRun run(b.scene());
    run.steps(1); // the fall of one step, m g h, is stopped: that pays for a lift of g h²/2 or so
    EXPECT_LT(run.grain(0).x[1], 0.49 + g * settings.h * settings.h);
    EXPECT_GE(run.grain(0).x[1], 0.49);
}

TEST(Tolerance, MayStopTheRunAtTheMaximum) {
    SceneBuilder b(0);
    b.floor();
    for (int k = 0; k < 30; ++k) {
        b.grain(0.5, {0, 0.5 * (2 * k + 1)});
    }
    auto settings = solver(0.01, 10);
    settings.tolerance = 1e-9;
    settings.max_sweeps = 50;
    auto stopping = b;
    b.stage(settings);
    SerialRun accepted(b.scene());
    accepted.steps(1);
    EXPECT_EQ(accepted.simulation().counters().unconverged, 1);
    settings.at_max = SolverSettings::AtMax::stop;
    stopping.stage(settings);
    SerialRun stopped(stopping.scene());
    try {
        stopped.steps(1);
        FAIL() << "50 sweeps do not solve a stack of 30";
    } catch (const NumericalFailure& e) {
        EXPECT_NE(std::string(e.what()).find("max_sweeps = 50"), std::string::npos) << e.what();
    }
}

/// Cold, every step solves anew with too few sweeps, so a stack behaves like a soft elastic bar (Unger and Kertész 2003):
/// it is pressed together until approach velocities do what impulses do not remember. Warm, forces stay.
TEST(WarmStart, ColdStepsDoNotLearn) {
    const auto overlap = [](bool warm) {
        SceneBuilder b(0);
        b.floor();
        for (int k = 0; k < 20; ++k) {
            b.grain(0.5, {0, 0.5 * (2 * k + 1)});
        }
        auto settings = solver(1e-3, 10);
        settings.warm_start = warm;
        SerialRun run(b.stage(settings).scene());
        run.steps(300);
        return overlaps(run.simulation()).largest;
    };
    EXPECT_GT(overlap(false), 3 * overlap(true));
}

} // namespace
} // namespace nappe::test::trading_test
