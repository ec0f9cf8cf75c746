// The first two Sobol dimensions and Owen's nested uniform scrambling. They run when direction
// tables are built, not per ray, so the scrambling is the exact one: every bit is flipped by a hash
// of the bits above it (Owen 1995, "Randomly permuted (t,m,s)-nets and (t,s)-sequences").
#pragma once

#include <cstdint>

#include "omma/vec.h"
#include "physics/sampling/hash.h"

namespace omma {

// Dimension 0: van der Corput, the bits of the index mirrored.
OMMA_HD std::uint32_t sobol_0(std::uint32_t index) {
  std::uint32_t result = 0;
  for (std::uint32_t v = 1u << 31; index != 0; index >>= 1, v >>= 1)
    if (index & 1u) result ^= v;
  return result;
}

// Dimension 1: direction numbers of the primitive polynomial x + 1 (Sobol 1967), generated on the
// way: each is its predecessor xor itself shifted by one.
OMMA_HD std::uint32_t sobol_1(std::uint32_t index) {
  std::uint32_t result = 0;
  for (std::uint32_t v = 1u << 31; index != 0; index >>= 1, v ^= v >> 1)
    if (index & 1u) result ^= v;
  return result;
}

OMMA_HD std::uint32_t owen_scramble(std::uint32_t value, std::uint64_t seed) {
  std::uint32_t result = 0;
  std::uint64_t prefix = 1;  // the bits above, with a leading 1 so that their number counts too
  for (int bit = 31; bit >= 0; --bit) {
    const std::uint32_t in = (value >> bit) & 1u;
    const auto flip = static_cast<std::uint32_t>(mix_bits(hash_combine(seed, prefix)) >> 63);
    result |= (in ^ flip) << bit;
    prefix = (prefix << 1) | in;
  }
  return result;
}

}  // namespace omma
