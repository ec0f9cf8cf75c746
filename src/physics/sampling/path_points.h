// Where paths go: pairs of numbers in (0, 1) for each choice on the way of a ray. The samples of one
// unit are Owen-scrambled Sobol points for every choice, in an order of its own for each, so that
// choices are independent of each other and even over the samples (B. Burley, Practical hash-based
// Owen scrambling, JCGT 9(4), 2020). Any number of lanes; no state.
#pragma once

#include "physics/lanes/lanes.h"
#include "physics/sampling/hash.h"

namespace omma {

template <typename U>
OMMA_HD U reverse_bits(U x) {
  x = (x >> 16) | (x << 16);
  x = ((x & 0x00ff00ffu) << 8) | ((x & 0xff00ff00u) >> 8);
  x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
  x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
  return ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
}

// sobol_1 of an index whose bits are reversed already: its matrix is Pascal's triangle modulo 2,
// which is a product of five shifts.
template <typename U>
OMMA_HD U sobol_1_of_reversed(U x) {
  x ^= (x & 0x0000ffffu) << 16;
  x ^= (x & 0x00ff00ffu) << 8;
  x ^= (x & 0x0f0f0f0fu) << 4;
  x ^= (x & 0x33333333u) << 2;
  x ^= (x & 0x55555555u) << 1;
  return x;
}

// Owen scrambling of numbers whose bits are reversed, as a hash in which each bit changes only those
// above it (Burley 2020, with the constants of N. Vegdahl's "Building a better LK hash", 2021).
template <typename U>
OMMA_HD U scramble_reversed(U x, U seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

template <typename F>
struct UnitPair {
  F x, y;  // in (0, 1)
};

// In (0, 1), from the upper 23 bits: with one more the largest would be rounded to 1, which is no
// place in any table.
template <typename U>
OMMA_HD auto open_unit(U bits) {
  return (to_float(int_of(bits >> 9)) + 0.5f) * 0x1p-23f;
}

// The pair of choice number `choice` for sample `sample` of the unit with this hash.
template <typename U, typename Number>
OMMA_HD auto path_pair(U hash, U sample, Number choice) {
  const U seed = mix_bits_32(hash + choice * 0x9e3779b9u);
  // The order: samples shuffled by a scrambling of their numbers.
  const U index = reverse_bits(scramble_reversed(reverse_bits(sample), seed));
  const U reversed = reverse_bits(index);
  // sobol_0 is the reversed index; scrambling works on reversed numbers, so on the index itself.
  const U x = reverse_bits(scramble_reversed(index, mix_bits_32(seed + 0x68bc21ebu)));
  const U y = reverse_bits(scramble_reversed(reverse_bits(sobol_1_of_reversed(reversed)),
                                             mix_bits_32(seed + 0x02e5be93u)));
  using F = decltype(open_unit(x));
  return UnitPair<F>{open_unit(x), open_unit(y)};
}

}  // namespace omma
