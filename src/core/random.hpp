#pragma once
// Random numbers that are a pure function of (seed, stream, counter): no state to store, send or restart, and the same
// on every machine, which the std distributions do not promise.

#include "core/mix.hpp"

namespace nappe {

/// What the numbers are for; two purposes never share a sequence. Values are part of stored samples: never renumber.
enum class RandomStream : std::uint64_t { deposit_radius = 1, deposit_order = 2 };

/// 64 random bits. Local.
inline std::uint64_t random_bits(std::uint64_t seed, RandomStream stream, std::uint64_t counter) {
    const std::uint64_t sequence = mix(mix(seed), static_cast<std::uint64_t>(stream));
    return mix(sequence, counter);
}

/// Uniform in [0, 1): the upper 53 bits, each value exactly representable. Local.
inline double random_uniform(std::uint64_t seed, RandomStream stream, std::uint64_t counter) {
    return static_cast<double>(random_bits(seed, stream, counter) >> 11) * 0x1.0p-53;
}

} // namespace nappe
