// Whatever moves between ranks arrives whole: grains, impulses, ghosts; and what does not is noticed.
#include "core/error.hpp"
#include "support/strewn_grains.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <string>

namespace nappe {
namespace {

using test::Layout;
using test::margin_for;
using test::SpreadGrains;
using test::strewn_grains;

constexpr double side = 8; // [m]

/// Collective. Every grain is on one rank, bit for bit, where its tile is owned, in the order of (tile, id).
void expect_all_grains_at_home(const Communicator& world, const SpreadGrains& spread) {
    const auto& grid = spread.domain.grid();
    const auto own = test::own_records(spread.state);
    auto everywhere = world.all_gather(own); // before any assertion, or the other ranks would wait for this one
    std::pair<TileKey, GlobalId> before{0, -1};
    for (const auto& g : own) {
        const std::pair<TileKey, GlobalId> here{grid.key(test::position(g)), g.id};
        ASSERT_LT(before, here) << "rows are not in the order of (tile, id)";
        ASSERT_EQ(spread.domain.directory().owner(here.first), world.rank()) << "grain " << g.id;
        before = here;
    }
    std::sort(everywhere.begin(), everywhere.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
    ASSERT_EQ(everywhere.size(), spread.all.size());
    for (std::size_t k = 0; k < everywhere.size(); ++k) {
        ASSERT_TRUE(test::same_bits(everywhere[k], spread.all[k])) << "grain " << spread.all[k].id;
    }
    ASSERT_EQ(spread.domain.n_grains(), static_cast<std::int64_t>(spread.all.size()));
}

/// Collective. Every impulse is on one rank, bit for bit, and that rank owns the contact's lower grain.
void expect_all_impulses_at_home(const Communicator& world, const SpreadGrains& spread) {
    auto everywhere = world.all_gather(spread.impulses());
    std::sort(everywhere.begin(), everywhere.end(),
              [](const auto& a, const auto& b) { return a.lo != b.lo ? a.lo < b.lo : a.hi < b.hi; });
    std::size_t at = 0;
    for (const auto& g : spread.all) {
        for (const auto& row : test::impulses_of(g.id)) {
            ASSERT_LT(at, everywhere.size());
            ASSERT_EQ(everywhere[at].lo, row.lo);
            ASSERT_EQ(everywhere[at].hi, row.hi);
            ASSERT_TRUE(test::same_bits(everywhere[at].r_n, row.r_n));
            ASSERT_TRUE(test::same_bits(everywhere[at].r_t[0], row.r_t[0]));
            ++at;
        }
    }
    ASSERT_EQ(at, everywhere.size());
}

TEST(Domain, SpreadsGrainsAndImpulsesFromAnyLayout) {
    const Communicator world;
    for (const auto layout : test::layouts) {
        for (const GlobalId n : {1200, 3, 1, 0}) {
            SCOPED_TRACE(testing::Message() << n << " grains, layout " << static_cast<int>(layout));
            const SpreadGrains spread(world, strewn_grains(n, margin_for(side)), side, layout);
            expect_all_grains_at_home(world, spread);
            expect_all_impulses_at_home(world, spread);
        }
    }
}

TEST(Domain, MigrationKeepsGrainsAndImpulses) {
    const Communicator world;
    SpreadGrains spread(world, strewn_grains(1200, margin_for(side)), side);
    // Within a tile, to the next, and clean over several into land where no tile has been.
    for (const double far : {0.1, 3.0, 8.0, 60.0, 8.0}) {
        spread.move_all(far, static_cast<std::uint64_t>(far * 10));
        SCOPED_TRACE(testing::Message() << "moved by " << far);
        expect_all_grains_at_home(world, spread);
        expect_all_impulses_at_home(world, spread);
    }
}

TEST(Domain, RanksAgreeOnWhoOwnsATileThatSeveralEnterAtOnce) {
    const Communicator world;
    SpreadGrains spread(world, strewn_grains(1200, 0), side);
    for (auto& x : spread.state.x) { // every rank's grains into one new tile
        x = {1001.0 + 1e-3 * x[0], 1003.0};
    }
    for (auto& g : spread.all) {
        g.x = {1001.0 + 1e-3 * g.x[0], 1003.0};
    }
    spread.rebuild();
    const auto owner = spread.domain.directory().owner(spread.domain.grid().key({1001.0, 1003.0}));
    for (const auto other : world.all_gather(std::vector<std::int32_t>{owner})) {
        EXPECT_EQ(other, owner);
    }
    expect_all_grains_at_home(world, spread);
}

/// Work that grows to the right, so that an even cut by grains is uneven by work.
std::vector<TileWork> work_of_own_tiles(const SpreadGrains& spread) {
    std::map<TileKey, std::int64_t> work;
    for (LocalId i = 0; i < spread.state.n_own; ++i) {
        const TileKey key = spread.domain.grid().key(spread.state.x[i]);
        work[key] += 1 + 40 * std::max<std::int64_t>(0, TileGrid<2>::unpack(key)[0]);
    }
    std::vector<TileWork> rows;
    for (const auto& [key, w] : work) {
        rows.push_back({key, w});
    }
    return rows;
}

TEST(Domain, BalancingEvensCountedWorkAndLosesNothing) {
    const Communicator world;
    SpreadGrains spread(world, strewn_grains(4000, margin_for(side)), side, Layout::scattered, test::always(1.05));
    const bool moved = spread.domain.balance(work_of_own_tiles(spread), {});
    EXPECT_EQ(moved, world.size() > 1);
    const double before = spread.domain.last_imbalance();
    spread.rebuild();
    expect_all_grains_at_home(world, spread);
    expect_all_impulses_at_home(world, spread);
    if (world.size() > 1) {
        EXPECT_GT(before, 1.3) << "the case is too easy";
        // 60 tiles, the heaviest 1/30 of the work: five parts can not be expected nearer than about that times five.
        spread.domain.balance(work_of_own_tiles(spread), {});
        EXPECT_LT(spread.domain.last_imbalance(), 1.2);
    }
}

TEST(Domain, BalancingKeepsAnEvenCut) {
    const Communicator world;
    SpreadGrains spread(world, strewn_grains(400, 0), side, Layout::scattered, test::always(1000.0));
    EXPECT_FALSE(spread.domain.balance(work_of_own_tiles(spread), {}));
    const auto before = test::own_records(spread.state).size();
    spread.rebuild();
    EXPECT_EQ(test::own_records(spread.state).size(), before);
}

TEST(Domain, GhostsAreTheGrainsInReachOfOwnTilesAndNoOthers) {
    const Communicator world;
    SpreadGrains spread(world, strewn_grains(800, margin_for(side)), side);
    for (int round = 0; round < 3; ++round) {
        double widest = 0;
        for (const auto& g : spread.all) {
            widest = std::max(widest, g.radius + g.margin);
        }
        const auto& grid = spread.domain.grid();
        const auto& directory = spread.domain.directory();
        std::set<TileKey> tiles; // all there can be, and a ring of those where nobody has been
        for (const auto& g : spread.all) {
            for (const TileKey key : TileGrid<2>::ring(grid.key(test::position(g)))) {
                tiles.insert(key);
            }
        }
        std::set<GlobalId> wanted;
        for (const auto& g : spread.all) {
            const auto x = test::position(g);
            const double range = g.radius + g.margin + widest;
            if (directory.owner(grid.key(x)) != world.rank() &&
                std::any_of(tiles.begin(), tiles.end(), [&](TileKey key) {
                    return directory.owner(key) == world.rank() && grid.distance(x, key) <= range;
                })) {
                wanted.insert(g.id);
            }
        }
        const std::set<GlobalId> found(spread.state.id.begin() + spread.state.n_own, spread.state.id.end());
        EXPECT_EQ(found.size(), static_cast<std::size_t>(spread.state.n_held() - spread.state.n_own)) << "held twice";
        EXPECT_EQ(found, wanted) << "round " << round;
        for (LocalId i = spread.state.n_own; i < spread.state.n_held(); ++i) {
            EXPECT_TRUE(
                test::same_bits(spread.state.record(i), spread.all[static_cast<std::size_t>(spread.state.id[i])]));
        }
        spread.move_all(5.0, static_cast<std::uint64_t>(round));
    }
}

TEST(Domain, CandidatesOfAllRanksAreEachPairInReachOnce) {
    const Communicator world;
    const SpreadGrains spread(world, strewn_grains(800, margin_for(side)), side);
    const Walls<2> no_walls({});
    const auto set = find_candidates(spread.state, spread.domain.grid(), no_walls, spread.memory);
    struct Pair {
        GlobalId lo, hi;
        auto operator<=>(const Pair&) const = default;
    };
    std::vector<Pair> mine;
    for (std::size_t c = 0; c < set.a.size(); ++c) {
        mine.push_back({spread.state.id[set.a[c]], spread.state.id[set.b[c]]});
        EXPECT_LT(set.a[c], spread.state.n_own) << "the lower grain is not owned";
    }
    auto found = world.all_gather(mine);
    std::sort(found.begin(), found.end());
    std::vector<Pair> wanted;
    for (const auto& a : spread.all) {
        for (const auto& b : spread.all) {
            const double range = (a.radius + a.margin) + (b.radius + b.margin);
            if (a.id < b.id && (test::position(a) - test::position(b)).squaredNorm() <= range * range) {
                wanted.push_back({a.id, b.id});
            }
        }
    }
    EXPECT_GT(wanted.size(), 1000u) << "the case is too easy";
    EXPECT_TRUE(found == wanted) << found.size() << " pairs found, " << wanted.size() << " in reach";
}

/// The rank whose grains the next tests tamper with: the first that has some.
bool is_first_with_grains(const Communicator& world, const State<2>& state) {
    return -world.max(state.n_own > 1 ? static_cast<std::int64_t>(-world.rank()) : -1'000'000) == world.rank();
}

/// Collective. Gives the state's own grains to `tamper` on one rank, and expects all ranks to notice alike.
template <class Tamper>
void expect_noticed(const Communicator& world, Tamper&& tamper, const std::string& said) {
    SpreadGrains spread(world, strewn_grains(300, 0.3), side);
    if (is_first_with_grains(world, spread.state)) {
        auto own = test::own_records(spread.state);
        tamper(own);
        spread.state.assign(own, {}, SpreadGrains::n_wall_bodies);
    }
    std::string text = "nothing";
    try {
        spread.rebuild();
    } catch (const SystemError& e) {
        text = e.what();
    }
    EXPECT_NE(text.find("lost or doubled"), std::string::npos) << text;
    EXPECT_NE(text.find(said), std::string::npos) << text;
}

TEST(Domain, NoticesALostGrain) {
    const Communicator world;
    expect_noticed(
        world, [](auto& own) { own.pop_back(); }, "299 of 300");
}

TEST(Domain, NoticesADoubledGrain) {
    const Communicator world;
    expect_noticed(
        world, [](auto& own) { own.push_back(own.front()); }, "301 of 300");
}

TEST(Domain, NoticesThatOneGrainTookTheNameOfAnother) {
    const Communicator world;
    expect_noticed(
        world, [](auto& own) { own.front().id = own.back().id; }, "ids changed");
}

TEST(Domain, NoticesThatTwoGrainsSwappedOneForTwoNames) {
    // Sums of ids would not: 3 + 5 = 4 + 4. The check mixes their bits first.
    const Communicator world;
    expect_noticed(
        world,
        [](auto& own) {
            own.front().id += 1;
            own.back().id -= 1;
        },
        "ids changed");
}

TEST(Domain, NoticesAChangedMass) {
    const Communicator world;
    // By the least that shows in the total of 300 grains.
    expect_noticed(
        world, [](auto& own) { own.front().mass *= 1 + 1e-12; }, "ids complete");
}

TEST(Domain, GrainOutOfTheWorldIsTheSameErrorOnAllRanks) {
    const Communicator world;
    for (const double away : {1e300, -1e14, std::numeric_limits<double>::quiet_NaN()}) {
        SpreadGrains spread(world, strewn_grains(300, 0.3), side);
        for (LocalId i = 0; i < spread.state.n_own; ++i) {
            if (spread.state.id[i] == 123) {
                spread.state.x[i][0] = away;
            }
        }
        std::string text = "nothing";
        try {
            spread.rebuild();
        } catch (const NumericalFailure& e) {
            text = e.what();
        }
        EXPECT_NE(text.find("grain 123 left the world"), std::string::npos) << text;
    }
}

} // namespace
} // namespace nappe
