#pragma once
// Blocks: grains that hang together by bonds, directly or over others.

#include "core/types.hpp"

#include <compare>
#include <cstdint>
#include <span>

namespace nappe {

/// Trivially copyable.
struct BondedPair {
    GlobalId a = 0, b = 0;
    auto operator<=>(const BondedPair&) const = default;
};

struct Clusters {
    std::int64_t largest = 0;         ///< grains of the largest block
    std::int64_t detached = 0;        ///< other blocks, of two grains or more
    std::int64_t detached_grains = 0; ///< in them
    std::int64_t single = 0;          ///< grains without a bond to another
};

/// Local. @param n grains, ids 0 … n - 1 @param bonds in any order, one pair as often as you like.
Clusters clusters(std::int64_t n, std::span<const BondedPair> bonds);

} // namespace nappe
