#pragma once
// Square tiles over the plane (cubes in space). Order, colour and neighbours of tiles are functions of position alone,
// so that nothing computed can depend on which rank owns what.

#include "core/types.hpp"

#include <array>
#include <cmath>
#include <cstdint>

namespace nappe {

/// A tile's name: its integer coordinates packed so that comparing keys compares coordinates lexicographically.
using TileKey = std::uint64_t;

/// Tiles of one colour of the 2 x 2 (x 2) colouring never touch the same grain, if the side exceeds twice the reach.
template <int D>
inline constexpr int n_tile_colours = 1 << D;

template <int D>
class TileGrid {
public:
    using Coordinates = std::array<std::int64_t, D>;

    /// @param origin of the grid [m]  @param side S [m] > 0
    TileGrid(const Vec<D>& origin, double side) : origin_(origin), side_(side) {}

    double side() const { return side_; }

    /// Coordinates of the tile that holds x; out of range far outside any world: see in_range.
    Coordinates coordinates(const Vec<D>& x) const {
        Coordinates c;
        for (int d = 0; d < D; ++d) {
            c[d] = static_cast<std::int64_t>(std::floor((x[d] - origin_[d]) / side_));
        }
        return c;
    }

    /// Whether a position is one the grid can name (finite, and within 2^(bits-2) tiles of the origin).
    bool in_range(const Vec<D>& x) const {
        for (int d = 0; d < D; ++d) {
            if (!(std::abs((x[d] - origin_[d]) / side_) < furthest)) {
                return false;
            }
        }
        return true;
    }

    TileKey key(const Vec<D>& x) const { return pack(coordinates(x)); }

    static TileKey pack(const Coordinates& c) {
        TileKey key = 0;
        for (int d = 0; d < D; ++d) {
            key = (key << bits) | static_cast<TileKey>(c[d] + offset);
        }
        return key;
    }

    static Coordinates unpack(TileKey key) {
        Coordinates c;
        for (int d = D - 1; d >= 0; --d) {
            c[d] = static_cast<std::int64_t>(key & mask) - offset;
            key >>= bits;
        }
        return c;
    }

    static int colour(TileKey key) {
        const auto c = unpack(key);
        int colour = 0;
        for (int d = 0; d < D; ++d) {
            colour |= static_cast<int>(c[d] & 1) << d;
        }
        return colour;
    }

    static constexpr int n_ring = D == 2 ? 9 : 27;

    /// The tile itself and those around it, in the order of their keys.
    static std::array<TileKey, n_ring> ring(TileKey key) {
        const auto centre = unpack(key);
        std::array<TileKey, n_ring> keys;
        for (int i = 0; i < n_ring; ++i) {
            Coordinates c;
            int rest = i;
            for (int d = D - 1; d >= 0; --d) {
                c[d] = centre[d] + rest % 3 - 1;
                rest /= 3;
            }
            keys[i] = pack(c);
        }
        return keys;
    }

    /// Lower corner of a tile [m].
    Vec<D> corner(TileKey key) const {
        const auto c = unpack(key);
        Vec<D> lower;
        for (int d = 0; d < D; ++d) {
            lower[d] = origin_[d] + static_cast<double>(c[d]) * side_;
        }
        return lower;
    }

    /// Distance from x to the nearest point of a tile, 0 inside [m].
    double distance(const Vec<D>& x, TileKey key) const {
        const Vec<D> lower = corner(key);
        double sum = 0;
        for (int d = 0; d < D; ++d) {
            const double below = lower[d] - x[d];
            const double above = x[d] - (lower[d] + side_);
            const double out = below > 0 ? below : (above > 0 ? above : 0);
            sum += out * out;
        }
        return std::sqrt(sum);
    }

private:
    static constexpr int bits = 64 / D;
    static constexpr TileKey mask = (TileKey{1} << bits) - 1;
    static constexpr std::int64_t offset = std::int64_t{1} << (bits - 1);
    static constexpr auto furthest = static_cast<double>(std::int64_t{1} << (bits - 2));

    Vec<D> origin_;
    double side_;
};

} // namespace nappe
