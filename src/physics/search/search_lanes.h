// What the search of a hierarchy does side by side besides the rays of a packet: the eight children
// of a node, the four triangles of a quad. On a graphics card, where every ray is a thread, each of
// these goes one by one.
#pragma once

#include "physics/lanes/lanes.h"

namespace omma {

#if defined(__CUDACC__)
inline constexpr int child_lanes = 1;
using ChildFloats = float;
inline constexpr int quad_lanes = 1;
using QuadFloats = float;
OMMA_HD float read_children(const std::uint8_t* byte) {
  return static_cast<float>(*byte);
}
OMMA_HD unsigned child_bits(bool condition) {
  return condition ? 1u : 0u;
}
#else
inline constexpr int quad_lanes = 4;
using QuadFloats = float __attribute__((vector_size(16)));
#if defined(__AVX2__)
inline constexpr int child_lanes = 8;
using ChildFloats = float __attribute__((vector_size(32)));
using ChildInts = std::int32_t __attribute__((vector_size(32)));
// Bytes as numbers; GCC 12 converts them one by one.
OMMA_HD ChildFloats read_children(const std::uint8_t* bytes) {
  const __m128i eight = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(bytes));
  return (ChildFloats)_mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(eight));
}
OMMA_HD unsigned child_bits(ChildInts mask) {
  return static_cast<unsigned>(_mm256_movemask_ps((__m256)mask));
}
#else
inline constexpr int child_lanes = 4;
using ChildFloats = float __attribute__((vector_size(16)));
using ChildInts = std::int32_t __attribute__((vector_size(16)));
OMMA_HD ChildFloats read_children(const std::uint8_t* bytes) {
#if defined(__SSE2__)
  int four;
  memcpy(&four, bytes, sizeof four);
  const __m128i zero = _mm_setzero_si128();
  const __m128i shorts = _mm_unpacklo_epi8(_mm_cvtsi32_si128(four), zero);
  return (ChildFloats)_mm_cvtepi32_ps(_mm_unpacklo_epi16(shorts, zero));
#elif defined(__ARM_NEON)
  std::uint32_t four;
  memcpy(&four, bytes, sizeof four);
  const uint16x8_t shorts = vmovl_u8(vreinterpret_u8_u32(vdup_n_u32(four)));
  return (ChildFloats)vcvtq_f32_u32(vmovl_u16(vget_low_u16(shorts)));
#elif defined(__wasm_simd128__)
  const v128_t shorts = wasm_u16x8_extend_low_u8x16(wasm_v128_load32_zero(bytes));
  return (ChildFloats)wasm_f32x4_convert_i32x4(wasm_u32x4_extend_low_u16x8(shorts));
#else
  return __builtin_convertvector((ChildInts{bytes[0], bytes[1], bytes[2], bytes[3]}), ChildFloats);
#endif
}
OMMA_HD unsigned child_bits(ChildInts mask) {
  return lane_bits(mask);
}
#endif
#endif

template <typename F>
OMMA_HD F least(F a, F b) {
  return a < b ? a : b;
}
template <typename F>
OMMA_HD F most(F a, F b) {
  return a > b ? a : b;
}

#if defined(__wasm_simd128__)
// One instruction for each; pmin(x, y) is y < x ? y : x.
OMMA_HD Floats least(Floats a, Floats b) {
  return (Floats)wasm_f32x4_pmin((v128_t)b, (v128_t)a);
}
OMMA_HD Floats most(Floats a, Floats b) {
  return (Floats)wasm_f32x4_pmax((v128_t)b, (v128_t)a);
}
#endif

// Of one lane or all, the least and the greatest.
OMMA_HD float least_lane(float x) {
  return x;
}
OMMA_HD float most_lane(float x) {
  return x;
}
#if !defined(__CUDACC__)
// Each lane beside the one `step` away from it, in a circle.
template <int step, int... k>
OMMA_HD Floats turn_lanes(Floats x, std::integer_sequence<int, k...>) {
  return shuffle(x, x, std::integer_sequence<int, ((k + step) % lane_width)...>{});
}
template <int step = lane_width / 2>
OMMA_HD Floats least_of_all(Floats x) {
  const Floats other = turn_lanes<step>(x, std::make_integer_sequence<int, lane_width>{});
  if constexpr (step == 1)
    return least(x, other);
  else
    return least_of_all<step / 2>(least(x, other));
}
OMMA_HD float least_lane(Floats x) {
  return least_of_all(x)[0];
}
OMMA_HD float most_lane(Floats x) {
  return -least_of_all(-x)[0];
}
#endif

}  // namespace omma
