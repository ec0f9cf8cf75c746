// The physics is written once for any number of lanes: `F` is a float (one ray: device code,
// filters, tests) or a vector of floats (a processor's packets, `Floats`), `I` and `U` the integers
// beside it. Arithmetic, comparisons and `mask ? a : b` read the same for both; what differs is
// here for one lane, in lanes_simd.h for vectors.
//
// A packet of rays lies in memory as [lane] (ray_packet.h) and goes through the arithmetic some
// lanes at a time; Lanes says how many there are and how many go at once. So nearly every function
// has the loop
//
//   for (int l = 0; l < L::count; l += L::width) {
//     const F t = load<F>(rays.t_far_m + l);
//     ...
//     store(rays.t_far_m + l, is_hit ? nearer : t);
//   }
//
// Six functions to know: `load` and `store` (lanes that lie one behind the other), `gather` (a
// table read at an index of each lane's own), `broadcast` (one number for all lanes), `keep` (x
// where a comparison holds, else zero) and `any_lane` (whether it holds anywhere). Which lanes of a
// packet are on is a LaneMask (lane_mask.h), vectors of three are in vector3.h, tables with a row
// for each lane in rows.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "physics/lanes/lanes_simd.h"

namespace omma {

template <typename F>
OMMA_HD F broadcast(float x) {
  return F{} + x;
}

// Lanes that lie in memory one behind the other; T is a lane's type, or any of that size.
// A card has one lane, and would copy it byte by byte, as memcpy takes it to lie at any address.
template <typename Vector, typename T>
OMMA_HD Vector load(const T* p) {
#if defined(__CUDACC__)
  return __builtin_bit_cast(Vector, *p);
#else
  Vector v;
  memcpy(&v, p, sizeof v);
  return v;
#endif
}
template <typename Vector, typename T>
OMMA_HD void store(T* p, Vector v) {
#if defined(__CUDACC__)
  *p = __builtin_bit_cast(T, v);
#else
  memcpy(p, &v, sizeof v);
#endif
}

OMMA_HD std::int32_t to_int(float x) {
  return static_cast<std::int32_t>(x);
}
OMMA_HD float to_float(std::int32_t i) {
  return static_cast<float>(i);
}
template <typename T>
OMMA_HD T gather(const T* base, std::int32_t index) {
  return base[index];
}
// base[2 * index] and the one behind it.
template <typename T>
OMMA_HD Pair<T> gather_pair(const T* base, std::int32_t index) {
  return {base[2 * index], base[2 * index + 1]};
}
// Four bytes from 4 * index on, the first lowest; on a card `base` lies at a multiple of 4.
OMMA_HD std::int32_t gather_bytes(const std::uint8_t* base, std::int32_t index) {
  const std::uint8_t* at = base + 4 * static_cast<std::ptrdiff_t>(index);
#if defined(__CUDA_ARCH__)
  at = static_cast<const std::uint8_t*>(__builtin_assume_aligned(at, 4));
#endif
  std::int32_t bytes;
  memcpy(&bytes, at, sizeof bytes);
  return bytes;
}
OMMA_HD float sqrt_lanes(float x) {
  return sqrtf(x);
}
OMMA_HD bool any_lane(bool condition) {
  return condition;
}
// A bit for each lane where a comparison holds, the first lane lowest.
OMMA_HD unsigned lane_bits(bool condition) {
  return condition ? 1 : 0;
}
// x where a comparison holds, else zero.
template <typename T>
OMMA_HD T keep(bool condition, T x) {
  return condition ? x : T{};
}
// Lane l of the result is p[index[l]], 0 <= index[l] < the number of lanes.
OMMA_HD float pick(const float* p, std::int32_t index) {
  return p[index];
}
OMMA_HD void store_wide(double* p, float x) {
  *p = static_cast<double>(x);
}
OMMA_HD std::int32_t int_of(std::uint32_t x) {
  return static_cast<std::int32_t>(x);
}
OMMA_HD std::uint32_t uint_of(std::int32_t x) {
  return static_cast<std::uint32_t>(x);
}
OMMA_HD std::int32_t bits_of(float x) {
  std::int32_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}
OMMA_HD float float_of(std::int32_t bits) {
  float x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

// base[3 * index] and the two behind it, for each lane.
template <typename T>
OMMA_HD void gather_3(const T* base, std::int32_t index, T (&out)[3]) {
  for (int k = 0; k < 3; ++k) out[k] = base[3 * static_cast<std::ptrdiff_t>(index) + k];
}
// The lanes whose bit is set, one behind the other from `to` on.
template <typename T>
OMMA_HD void store_some(T* to, float x, unsigned bits) {
  if (bits != 0) store(to, x);
}

// Packets of `count` rays, of which `width` go through the arithmetic at once.
template <int count_, int width_>
struct Lanes;

template <int count_>
struct Lanes<count_, 1> {
  static constexpr int count = count_, width = 1;
  using F = float;
  using I = std::int32_t;
  using U = std::uint32_t;
};

#if !defined(__CUDACC__)
template <int count_>
struct Lanes<count_, lane_width> {
  static constexpr int count = count_, width = lane_width;
  using F = Floats;
  using I = Ints;
  using U = Uints;
};
#endif

// The number of each of the lanes that go at once.
template <typename L>
OMMA_HD typename L::I lane_numbers() {
  if constexpr (L::width == 1) {
    return 0;
  } else {
    typename L::I number;
    for (int l = 0; l < L::width; ++l) number[l] = l;
    return number;
  }
}

OMMA_HD int lowest_bit(unsigned bits) {
#if defined(__CUDA_ARCH__)
  return __ffs(static_cast<int>(bits)) - 1;
#else
  return __builtin_ctz(bits);
#endif
}

OMMA_HD int bits_in(unsigned bits) {
#if defined(__CUDA_ARCH__)
  return __popc(bits);
#else
  return __builtin_popcount(bits);
#endif
}

// Asks for a line of memory that will be read. Compilers drop a function that has nothing but
// prefetches, as if it did nothing: the statement beside it says that it does.
OMMA_HD void fetch_line(const void* line) {
#if !defined(__CUDACC__)
  __builtin_prefetch(line);
  asm volatile("" : : "r"(line));
#else
  (void)line;
#endif
}

// The greatest integer not above x, |x| < 2^31; the same steps for one lane and for many.
template <typename F>
OMMA_HD F floor_lanes(F x) {
  const F towards_zero = to_float(to_int(x));
  return towards_zero > x ? towards_zero - 1.0f : towards_zero;
}

// Into [0, 1]. Comparisons, not fminf and fmaxf, which compilers may turn into calls.
template <typename F>
OMMA_HD F clamp_unit_lanes(F x) {
  x = x > 0.0f ? x : broadcast<F>(0.0f);
  return x < 1.0f ? x : broadcast<F>(1.0f);
}

}  // namespace omma
