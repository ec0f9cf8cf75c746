// Random numbers as a stateless function of what they are for: (seed, pose, ommatidium, ...).
// No generator state exists anywhere, so that results do not depend on the order of work.
#pragma once

#include <cstdint>

#include "omma/vec.h"

namespace omma {

// A bijective mixer of 64 bits: the finaliser of SplitMix64 (Steele, Lea, Flood 2014, OOPSLA).
OMMA_HD std::uint64_t mix_bits(std::uint64_t x) {
  x ^= x >> 30;
  x *= 0xbf58476d1ce4e5b9ull;
  x ^= x >> 27;
  x *= 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

OMMA_HD std::uint64_t hash_combine(std::uint64_t h, std::uint64_t value) {
  return mix_bits((h + value) * 0x9e3779b97f4a7c15ull + 0x632be59bd9b4e019ull);
}

// All of one pose's random numbers start here; done once per pose and block of ommatidia.
OMMA_HD std::uint64_t pose_hash(std::uint64_t seed, std::uint64_t pose) {
  return hash_combine(mix_bits(seed ^ 0x6f6d6d61ull), pose);
}

// A bijective mixer of 32 bits with little bias (C. Wellons, Prospecting for hash functions, 2018),
// any number of lanes.
template <typename U>
OMMA_HD U mix_bits_32(U x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  return x ^ (x >> 16);
}

// All of one ommatidium's at one pose.
template <typename U>
OMMA_HD U ommatidium_hash(std::uint64_t pose_bits, U ommatidium) {
  const U first = mix_bits_32(ommatidium ^ static_cast<std::uint32_t>(pose_bits));
  return mix_bits_32(first + static_cast<std::uint32_t>(pose_bits >> 32));
}

// Of one scramble of the ommatidium, where its directions are made on the way.
template <typename U>
OMMA_HD U scramble_hash(U ommatidium_bits, U scramble) {
  return mix_bits_32(ommatidium_bits + scramble * 0x9e3779b9u);
}

// Uniform in (0, 1) from the upper 32 bits.
OMMA_HD double unit_interval(std::uint64_t bits) {
  return (static_cast<double>(bits >> 32) + 0.5) * 0x1p-32;
}

}  // namespace omma
