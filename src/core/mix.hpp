#pragma once
// One 64-bit mixing function for hashes of the state and checks of ids.

#include <bit>
#include <cstdint>

namespace nappe {

/// A bijection of 64 bits in which every input bit reaches every output bit (the finaliser of MurmurHash3, public
/// domain).
inline std::uint64_t mix(std::uint64_t z) {
    z ^= z >> 33;
    z *= 0xff51afd7ed558ccdULL;
    z ^= z >> 33;
    z *= 0xc4ceb9fe1a85ec53ULL;
    z ^= z >> 33;
    return z;
}

/// Chains a value into a hash; order matters.
inline std::uint64_t mix(std::uint64_t hash, std::uint64_t value) {
    return mix(hash * 0x9e3779b97f4a7c15ULL + value + 1);
}

/// A double by its bits; −0 counts as 0.
inline std::uint64_t mix(std::uint64_t hash, double value) {
    return mix(hash, std::bit_cast<std::uint64_t>(value == 0 ? 0.0 : value));
}

} // namespace nappe
