// Candidates: complete against all pairs, in canonical order, in classes and tiles that share no grain.

#include "core/neighbours.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>

namespace nappe {
namespace {

constexpr double side = 4;

using Pair = std::pair<GlobalId, GlobalId>;

GrainRecord<2> grain(GlobalId id, const Vec<2>& x, double radius, double margin) {
    GrainRecord<2> g;
    g.id = id;
    g.x = {x[0], x[1]};
    g.radius = radius;
    g.mass = 1;
    g.u.inv_m = 1;
    g.margin = margin;
    return g;
}

Vec<2> position(const GrainRecord<2>& g) {
    return Vec<2>(g.x[0], g.x[1]);
}

/// Radii in [0.1, 0.4] and margins that with them come up to what tiles allow: 4 (r + margin) < side.
std::vector<GrainRecord<2>> random_grains(int n, double half_width, std::uint64_t seed) {
    std::mt19937_64 bits(seed);
    std::uniform_real_distribution<double> at(-half_width, half_width), radius(0.1, 0.4), share(0, 1);
    std::vector<GrainRecord<2>> grains;
    for (GlobalId id = 0; id < n; ++id) {
        const double r = radius(bits);
        grains.push_back(grain(7 * id % 2003, {at(bits), at(bits)}, r, share(bits) * (0.2499 * side - r)));
    }
    return grains;
}

/// Rows as Domain leaves them: owned ones by (tile, id), then ghosts by the same.
template <class Owned>
State<2> state_of(const std::vector<GrainRecord<2>>& grains, const TileGrid<2>& grid, LocalId n_walls, Owned&& owned) {
    std::map<std::pair<TileKey, GlobalId>, const GrainRecord<2>*> by_tile;
    for (const auto& g : grains) {
        by_tile[{grid.key(position(g)), g.id}] = &g;
    }
    std::vector<GrainRecord<2>> own, ghosts;
    for (const auto& [place, g] : by_tile) {
        (owned(place.first) ? own : ghosts).push_back(*g);
    }
    State<2> state;
    state.assign(own, ghosts, n_walls);
    return state;
}

std::vector<Wall<2>> some_walls() {
    Wall<2> fence, plate;
    fence.points = {{-7, -6}, {6, -6.5}, {6.2, 7}, {0, 0.3}};
    plate.points = {{-3, 2}, {-2, 2.1}};
    return {fence, plate};
}

double distance_to_segment(const Vec<2>& p, const Vec<2>& q, const Vec<2>& x) {
    const Vec<2> along = q - p;
    return (x - (p + std::clamp((x - p).dot(along) / along.squaredNorm(), 0.0, 1.0) * along)).norm();
}

/// All pairs, by the definition. Walls by feature: segments of a polyline, then its points.
std::set<Pair> all_pairs(const State<2>& state, const std::vector<Wall<2>>& walls, const std::vector<double>& margins) {
    std::set<Pair> pairs;
    for (LocalId i = 0; i < state.n_own; ++i) {
        const double reach = state.radius[i] + state.margin[i];
        for (LocalId j = 0; j < state.n_held(); ++j) {
            if (state.id[j] > state.id[i] &&
                (state.x[j] - state.x[i]).norm() <= reach + state.radius[j] + state.margin[j]) {
                pairs.insert({state.id[i], state.id[j]});
            }
        }
        GlobalId feature = 0;
        for (std::size_t w = 0; w < walls.size(); ++w) {
            const auto& points = walls[w].points;
            for (std::size_t k = 0; k + 1 < points.size(); ++k, ++feature) {
                if (distance_to_segment(points[k], points[k + 1], state.x[i]) <= reach + margins[w]) {
                    pairs.insert({state.id[i], wall_key + feature});
                }
            }
            for (std::size_t k = 0; k < points.size(); ++k, ++feature) {
                if ((state.x[i] - points[k]).norm() <= reach + margins[w]) {
                    pairs.insert({state.id[i], wall_key + feature});
                }
            }
        }
    }
    return pairs;
}

/// Names of the candidates, walls by feature whatever the side.
std::vector<Pair> names(const State<2>& state, const CandidateSet<2>& set) {
    std::vector<Pair> pairs;
    for (std::size_t c = 0; c < set.a.size(); ++c) {
        const GlobalId key = partner_key(state, set.b[c]);
        pairs.push_back({state.id[set.a[c]], key < wall_key ? key : wall_key + (key - wall_key) / 2});
    }
    return pairs;
}

TEST(Neighbours, AreAllThePairsThereAre) {
    const TileGrid<2> grid({0.3, -0.7}, side);
    const auto walls = some_walls();
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        Walls<2> features(walls);
        features.margin = {0.2, 0.05};
        auto grains = random_grains(seed == 5 ? 12 : 400, 8.0, seed);
        for (auto& g : grains) { // seed 4: still tiles beside tiles where grains move, which reach into them
            g.margin *= seed == 4 && TileGrid<2>::unpack(grid.key(position(g)))[0] % 2 == 0 ? 0.01 : 1.0;
        }
        for (const bool alone : {true, false}) { // with ghosts: every third column of tiles is another rank's
            const auto state = state_of(grains, grid, features.n_bodies(), [&](TileKey key) {
                return alone || (TileGrid<2>::unpack(key)[0] + 300) % 3 != 0;
            });
            ASSERT_EQ(alone, state.n_own == state.n_held());
            const auto set = find_candidates(state, grid, features, {});
            const auto found = names(state, set);
            const std::set<Pair> unique(found.begin(), found.end());
            EXPECT_EQ(unique.size(), found.size()) << "a pair twice";
            EXPECT_EQ(unique, all_pairs(state, walls, features.margin)) << "seed " << seed;
            if (seed < 5) {
                EXPECT_GT(found.size(), 500u) << "the case is dense enough to mean something";
            }
        }
    }
}

TEST(Neighbours, LargeGrainsMeetAllTheirPartnersBehindTheTiles) {
    const TileGrid<2> grid({0.3, -0.7}, side);
    const auto walls = some_walls();
    for (const bool alone : {true, false}) {
        Walls<2> features(walls);
        features.margin = {0.2, 0.05};
        auto grains = random_grains(400, 8.0, 6);
        const std::vector<std::size_t> large{3, 77, 200};
        for (std::size_t k = 0; k < large.size(); ++k) { // larger than tiles allow
            grains[large[k]].radius = 1.5 + static_cast<double>(k);
            grains[large[k]].margin = 0.5;
        }
        auto state = state_of(grains, grid, features.n_bodies(),
                              [&](TileKey key) { return alone || (TileGrid<2>::unpack(key)[0] + 300) % 3 != 0; });
        state.large_above = 0.4;
        const auto set = find_candidates(state, grid, features, {});
        ASSERT_TRUE(set.has_large());
        ASSERT_EQ(set.plain_tiles().size() + 1, set.tiles.size());

        // Every rank that has large grains has all their partners, so ghosts are as good as owned grains there.
        auto all = state;
        all.n_own = all.n_held();
        std::set<GlobalId> ids;
        GlobalId lowest = 0;
        for (LocalId i = state.n_held(); i-- > 0;) {
            if (state.is_large(i)) {
                ids.insert(state.id[i]);
            }
        }
        ASSERT_EQ(ids.size(), 3u);
        lowest = *ids.begin();
        std::set<Pair> of_tiles, of_large;
        for (const auto& pair : all_pairs(state, walls, features.margin)) {
            if (!ids.contains(pair.first) && !ids.contains(pair.second)) {
                of_tiles.insert(pair);
            }
        }
        for (const auto& pair : all_pairs(all, walls, features.margin)) {
            if (ids.contains(pair.first) || ids.contains(pair.second)) {
                of_large.insert(pair);
            }
        }
        const auto found = names(state, set);
        const auto end = static_cast<std::ptrdiff_t>(set.tiles.back().candidates_begin);
        EXPECT_EQ(std::set<Pair>(found.begin(), found.begin() + end), of_tiles);
        EXPECT_EQ(std::set<Pair>(found.begin() + end, found.end()), of_large);
        EXPECT_EQ(found.size(), of_tiles.size() + of_large.size()) << "a pair twice";
        EXPECT_GT(of_large.size(), 40u);

        const auto row = std::find(state.id.begin(), state.id.end(), lowest) - state.id.begin();
        EXPECT_EQ(set.counts_large, row < state.n_own) << "the owner of the first large grain counts";
    }
}

/// First fit, told naively: the least class in which neither grain has been seen.
std::vector<std::int32_t> first_fit(const std::vector<LocalId>& a, const std::vector<LocalId>& b, LocalId n_grains) {
    std::map<LocalId, std::set<std::int32_t>> taken;
    std::vector<std::int32_t> colour;
    for (std::size_t c = 0; c < a.size(); ++c) {
        std::int32_t k = 0;
        while (taken[a[c]].count(k) != 0 || (b[c] < n_grains && taken[b[c]].count(k) != 0)) {
            ++k;
        }
        taken[a[c]].insert(k);
        if (b[c] < n_grains) {
            taken[b[c]].insert(k);
        }
        colour.push_back(k);
    }
    return colour;
}

/// Class of each candidate of a tile, found again: all of them by key, then first fit.
std::map<Pair, std::int32_t> expected_classes(const State<2>& state, const CandidateSet<2>& set, const Tile& tile) {
    std::map<Pair, std::pair<LocalId, LocalId>> by_key;
    for (auto c = tile.candidates_begin; c < tile.candidates_end; ++c) {
        by_key[{state.id[set.a[c]], partner_key(state, set.b[c])}] = {set.a[c], set.b[c]};
    }
    std::vector<LocalId> a, b;
    for (const auto& [name, bodies] : by_key) {
        a.push_back(bodies.first);
        b.push_back(bodies.second);
    }
    const auto colour = first_fit(a, b, state.n_held());
    std::map<Pair, std::int32_t> classes;
    for (const auto& [name, bodies] : by_key) {
        const auto k = classes.size();
        classes[name] = colour[k];
    }
    return classes;
}

TEST(Neighbours, CanonicalOrder) {
    const TileGrid<2> grid({0, 0}, side);
    Walls<2> walls(some_walls());
    const auto state = state_of(random_grains(500, 8, 9), grid, walls.n_bodies(), [](TileKey) { return true; });
    const auto set = find_candidates(state, grid, walls, {});
    std::int32_t next = 0, next_class = 0;
    for (std::size_t t = 0; t < set.tiles.size(); ++t) {
        const Tile& tile = set.tiles[t];
        EXPECT_TRUE(t == 0 || set.tiles[t - 1].key < tile.key);
        EXPECT_EQ(tile.colour, TileGrid<2>::colour(tile.key));
        EXPECT_EQ(tile.candidates_begin, next);
        EXPECT_EQ(tile.classes_begin, next_class);
        next_class = tile.classes_end;
        const auto expected = expected_classes(state, set, tile);
        for (auto k = tile.classes_begin; k < tile.classes_end; ++k) {
            EXPECT_EQ(set.class_begin[static_cast<std::size_t>(k)], next) << "classes leave no hole";
            Pair last{-1, -1};
            for (; next < set.class_end(tile, k); ++next) {
                const Pair name{state.id[set.a[next]], partner_key(state, set.b[next])};
                EXPECT_LT(last, name) << "by key in a class";
                EXPECT_EQ(k - tile.classes_begin, expected.at(name));
                EXPECT_LT(name.first, name.second);
                EXPECT_EQ(grid.key(state.x_ref[set.a[next]]), tile.key)
                    << "a contact belongs to its lower grain's tile";
                last = name;
            }
        }
        EXPECT_EQ(tile.candidates_end, next);
    }
    EXPECT_EQ(next, set.size());
}

TEST(Neighbours, ClassesAreFirstFitAndShareNoGrain) {
    std::mt19937_64 bits(4);
    std::vector<std::uint64_t> used;
    for (const int n :
         {0, 1, 40, 600}) { // 600 pairs of 12 grains: up to 100 contacts a grain, more than a block of 64 classes
        const LocalId n_grains = 12;
        std::vector<LocalId> a, b;
        for (int c = 0; c < n; ++c) {
            a.push_back(static_cast<LocalId>(bits() % 12));
            b.push_back(
                static_cast<LocalId>((static_cast<std::uint64_t>(a.back()) + 1 + bits() % 15) % 16)); // 12 … 15: walls
            if (b.back() == a.back()) {
                b.back() = 13;
            }
        }
        std::vector<std::int32_t> colour;
        colour_contacts(a, b, n_grains, used, colour);
        EXPECT_EQ(colour, first_fit(a, b, n_grains));
        EXPECT_TRUE(std::all_of(used.begin(), used.end(), [](auto bits_left) { return bits_left == 0; })) << "scratch";
        EXPECT_TRUE(n < 600 || *std::max_element(colour.begin(), colour.end()) >= 64);
    }
}

/// A block among pebbles: far more than 64 contacts, each in a class of its own; the pebbles' own contacts fill the same classes.
TEST(Neighbours, AGrainWithHundredsOfContacts) {
    const TileGrid<2> grid({-20, -20}, 40);
    std::vector<GrainRecord<2>> grains = {grain(0, {0, 0}, 5, 0.01)};
    const int n = 300;
    for (int k = 0; k < n; ++k) {
        const double angle = 2 * M_PI * k / n;
        grains.push_back(grain(k + 1, 5.05 * Vec<2>(std::cos(angle), std::sin(angle)), 0.05, 0.01));
    }
    const Walls<2> none(std::vector<Wall<2>>{});
    const auto state = state_of(grains, grid, 0, [](TileKey) { return true; });
    const auto set = find_candidates(state, grid, none, {});
    ASSERT_EQ(set.tiles.size(), 1u);
    EXPECT_EQ(set.size(), 2 * n)
        << "each pebble touches the block and, 0.006 m apart with margins of 0.01, its two neighbours";
    EXPECT_EQ(set.tiles[0].classes_end, n) << "the block's contacts, one a class; its pebbles' find room among them";
    for (auto k = set.tiles[0].classes_begin; k < set.tiles[0].classes_end; ++k) {
        std::set<LocalId> seen;
        for (auto c = set.class_begin[static_cast<std::size_t>(k)]; c < set.class_end(set.tiles[0], k); ++c) {
            EXPECT_TRUE(seen.insert(set.a[c]).second);
            EXPECT_TRUE(seen.insert(set.b[c]).second);
        }
    }
}

/// What tile-parallel sweeps rest on, at the largest margins that tiles allow and grains thick enough to reach everywhere.
TEST(Neighbours, TilesOfOneColourShareNoGrain) {
    const TileGrid<2> grid({0, 0}, side);
    auto grains = random_grains(1500, 8, 21);
    for (auto& g : grains) {
        g.margin =
            0.2499 * side - g.radius; // Domain::largest_margin, for each grain's own radius: the worst that may come
    }
    Walls<2> walls(some_walls());
    const auto state = state_of(grains, grid, walls.n_bodies(), [](TileKey) { return true; });
    const auto set = find_candidates(state, grid, walls, {});
    std::array<std::map<LocalId, TileKey>, n_tile_colours<2>> tile_of;
    int across = 0;
    for (const auto& tile : set.tiles) {
        for (auto c = tile.candidates_begin; c < tile.candidates_end; ++c) {
            for (const LocalId i : {set.a[c], set.b[c]}) {
                if (i >= state.n_held()) {
                    continue; // walls are never written
                }
                const auto [it, fresh] = tile_of[static_cast<std::size_t>(tile.colour)].try_emplace(i, tile.key);
                EXPECT_EQ(it->second, tile.key) << "grain " << state.id[i];
                across += grid.key(state.x_ref[i]) != tile.key;
            }
        }
    }
    EXPECT_GT(across, 1000) << "many contacts do reach into other tiles";
}

TEST(Neighbours, RemembersImpulsesByName) {
    const TileGrid<2> grid({0, 0}, side);
    Walls<2> walls(some_walls());
    const auto state = state_of(random_grains(100, 4, 2), grid, walls.n_bodies(), [](TileKey) { return true; });
    const auto cold = find_candidates(state, grid, walls, {});
    std::vector<ContactRow<2>> rows;
    for (std::int32_t c = 0; c < cold.size(); c += 3) {
        rows.push_back({state.id[cold.a[c]], partner_key(state, cold.b[c]), 1.5 * c, {-0.5 * c}});
    }
    rows.push_back({100'000, 100'001, 9, {9}}); // a pair that has parted
    std::reverse(rows.begin(), rows.end());
    const auto warm = find_candidates(state, grid, walls, ContactMemory<2>(rows));
    ASSERT_EQ(warm.a, cold.a);
    ASSERT_EQ(warm.b, cold.b);
    for (std::int32_t c = 0; c < warm.size(); ++c) {
        EXPECT_EQ(warm.r_n[c], c % 3 == 0 ? 1.5 * c : 0.0);
        EXPECT_EQ(warm.r_t[c][0], c % 3 == 0 ? -0.5 * c : 0.0);
    }
    auto back = impulse_rows(state, warm);
    EXPECT_EQ(back.size(), rows.size() - 2) << "without the parted pair and the candidate 0, whose impulse is 0";
}

} // namespace
} // namespace nappe
