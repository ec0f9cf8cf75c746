// Vectors of floats and integers as a processor has them, and what is done to them by its
// instructions: conversions, masks, gathers, shuffles. A reader of the physics needs lanes.h only,
// which has the same functions for one lane; this is where a new instruction set goes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "omma/vec.h"
#if !defined(__CUDACC__)
#include <utility>
#if defined(__AVX2__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#elif defined(__ARM_NEON)
#include <arm_neon.h>
#elif defined(__wasm_simd128__)
#include <wasm_simd128.h>
#endif
#endif

namespace omma {

// Two neighbours in memory, for each lane.
template <typename T>
struct Pair {
  T first, second;
};

#if !defined(__CUDACC__)
// As many lanes as the instruction set has that this file is compiled for.
#if defined(__AVX512F__)
inline constexpr int lane_width = 16;
using Floats = float __attribute__((vector_size(64)));
using Ints = std::int32_t __attribute__((vector_size(64)));
using Uints = std::uint32_t __attribute__((vector_size(64)));
#elif defined(__AVX2__)
inline constexpr int lane_width = 8;
using Floats = float __attribute__((vector_size(32)));
using Ints = std::int32_t __attribute__((vector_size(32)));
using Uints = std::uint32_t __attribute__((vector_size(32)));
#else
inline constexpr int lane_width = 4;
using Floats = float __attribute__((vector_size(16)));
using Ints = std::int32_t __attribute__((vector_size(16)));
using Uints = std::uint32_t __attribute__((vector_size(16)));
#endif

OMMA_HD Ints to_int(Floats x) {
  return __builtin_convertvector(x, Ints);
}
OMMA_HD Floats to_float(Ints i) {
  return __builtin_convertvector(i, Floats);
}
// The same bits as another type.
OMMA_HD Ints int_of(Uints x) {
  return (Ints)x;
}
OMMA_HD Uints uint_of(Ints x) {
  return (Uints)x;
}
OMMA_HD Ints bits_of(Floats x) {
  return (Ints)x;
}
OMMA_HD Floats float_of(Ints bits) {
  return (Floats)bits;
}

// A bit for each lane of a comparison's result, the first lane lowest; square roots. The 512-bit
// intrinsics are the masked ones, all lanes on: GCC 12 warns of an uninitialised register in the
// plain ones (its bug 105593).
#if defined(__AVX512F__)
OMMA_HD unsigned lane_bits(Ints mask) {
  return _mm512_movepi32_mask((__m512i)mask);
}
OMMA_HD Floats sqrt_lanes(Floats x) {
  return (Floats)_mm512_maskz_sqrt_ps(0xffff, (__m512)x);
}
#elif defined(__AVX2__)
OMMA_HD unsigned lane_bits(Ints mask) {
  return static_cast<unsigned>(_mm256_movemask_ps((__m256)mask));
}
OMMA_HD Floats sqrt_lanes(Floats x) {
  return (Floats)_mm256_sqrt_ps((__m256)x);
}
#elif defined(__SSE2__)
OMMA_HD unsigned lane_bits(Ints mask) {
  return static_cast<unsigned>(_mm_movemask_ps((__m128)mask));
}
OMMA_HD Floats sqrt_lanes(Floats x) {
  return (Floats)_mm_sqrt_ps((__m128)x);
}
#elif defined(__ARM_NEON)
OMMA_HD unsigned lane_bits(Ints mask) {
  return vaddvq_u32((uint32x4_t)(mask & Ints{1, 2, 4, 8}));
}
OMMA_HD Floats sqrt_lanes(Floats x) {
  return (Floats)vsqrtq_f32((float32x4_t)x);
}
#elif defined(__wasm_simd128__)
OMMA_HD unsigned lane_bits(Ints mask) {
  return static_cast<unsigned>(wasm_i32x4_bitmask((v128_t)mask));
}
OMMA_HD Floats sqrt_lanes(Floats x) {
  return (Floats)wasm_f32x4_sqrt((v128_t)x);
}
#else
OMMA_HD unsigned lane_bits(Ints mask) {
  return (mask[0] & 1u) | (mask[1] & 2u) | (mask[2] & 4u) | (mask[3] & 8u);
}
OMMA_HD Floats sqrt_lanes(Floats x) {
  return Floats{sqrtf(x[0]), sqrtf(x[1]), sqrtf(x[2]), sqrtf(x[3])};
}
#endif

OMMA_HD bool any_lane(Ints mask) {
  return lane_bits(mask) != 0;
}
OMMA_HD Ints keep(Ints mask, Ints x) {
  return x & mask;
}
OMMA_HD Floats keep(Ints mask, Floats x) {
  return float_of(bits_of(x) & mask);
}
OMMA_HD void store_wide(double* p, Floats x) {
  using Doubles = double __attribute__((vector_size(8 * lane_width)));
  const Doubles wide = __builtin_convertvector(x, Doubles);
  memcpy(p, &wide, sizeof wide);
}

// Elements k... of those of a and, behind them, those of b.
template <typename Vector, int... k>
OMMA_HD Vector shuffle(Vector a, Vector b, std::integer_sequence<int, k...>) {
#if defined(__clang__) || __GNUC__ >= 12
  return __builtin_shufflevector(a, b, k...);
#else  // GCC 11 knows the same under another name
  return __builtin_shuffle(a, b, Ints{k...});
#endif
}

// Of the elements of a and those of b behind them: the even ones, and the odd ones.
template <int... k>
OMMA_HD Pair<Ints> every_second(Ints a, Ints b, std::integer_sequence<int, k...>) {
  return {shuffle(a, b, std::integer_sequence<int, (2 * k)...>{}),
          shuffle(a, b, std::integer_sequence<int, (2 * k + 1)...>{})};
}

#if defined(__AVX512F__)
// Masked with all lanes on: GCC 12 warns of an uninitialised register in the plain ones (bug
// 105593).
OMMA_HD Floats gather(const float* base, Ints i) {
  return (Floats)_mm512_mask_i32gather_ps(_mm512_setzero_ps(), 0xffff, (__m512i)i, base, 4);
}
OMMA_HD Ints gather(const std::int32_t* base, Ints i) {
  return (Ints)_mm512_mask_i32gather_epi32(_mm512_setzero_si512(), 0xffff, (__m512i)i, base, 4);
}
// A gather costs by the element, whatever its size: pairs as 64-bit elements cost half.
OMMA_HD Pair<Ints> gather_pairs_of_bits(const void* base, Ints i) {
  const __m512i zero = _mm512_setzero_si512();
  const __m256i low = _mm512_maskz_extracti64x4_epi64(0xf, (__m512i)i, 0);
  const __m256i high = _mm512_maskz_extracti64x4_epi64(0xf, (__m512i)i, 1);
  const Ints a = (Ints)_mm512_mask_i32gather_epi64(zero, 0xff, low, base, 8);
  const Ints b = (Ints)_mm512_mask_i32gather_epi64(zero, 0xff, high, base, 8);
  return every_second(a, b, std::make_integer_sequence<int, lane_width>{});
}
#elif defined(__AVX2__)
OMMA_HD Floats gather(const float* base, Ints i) {
  return (Floats)_mm256_i32gather_ps(base, (__m256i)i, 4);
}
OMMA_HD Ints gather(const std::int32_t* base, Ints i) {
  return (Ints)_mm256_i32gather_epi32(base, (__m256i)i, 4);
}
// A gather costs by the element, whatever its size: pairs as 64-bit elements cost half.
OMMA_HD Pair<Ints> gather_pairs_of_bits(const void* base, Ints i) {
  const auto* pairs = static_cast<const long long*>(base);
  const __m256i index = (__m256i)i;
  const Ints a = (Ints)_mm256_i32gather_epi64(pairs, _mm256_castsi256_si128(index), 8);
  const Ints b = (Ints)_mm256_i32gather_epi64(pairs, _mm256_extracti128_si256(index, 1), 8);
  return every_second(a, b, std::make_integer_sequence<int, lane_width>{});
}
#else
OMMA_HD Floats gather(const float* base, Ints i) {
  return Floats{base[i[0]], base[i[1]], base[i[2]], base[i[3]]};
}
OMMA_HD Ints gather(const std::int32_t* base, Ints i) {
  return Ints{base[i[0]], base[i[1]], base[i[2]], base[i[3]]};
}
// The first two of `stride` neighbours: both in one load.
template <int stride>
OMMA_HD Pair<Ints> gather_two_of(const void* base, Ints i) {
  const auto two = [&](int lane) {
    std::int64_t bits;
    memcpy(&bits, static_cast<const char*>(base) + 4 * stride * static_cast<std::ptrdiff_t>(i[lane]),
           sizeof bits);
    return bits;
  };
  using Wide = std::int64_t __attribute__((vector_size(16)));
  const Ints a = (Ints)Wide{two(0), two(1)}, b = (Ints)Wide{two(2), two(3)};
  return every_second(a, b, std::make_integer_sequence<int, lane_width>{});
}
OMMA_HD Pair<Ints> gather_pairs_of_bits(const void* base, Ints i) {
  return gather_two_of<2>(base, i);
}
#endif
OMMA_HD Ints gather_bytes(const std::uint8_t* base, Ints i) {
#if defined(__AVX512F__)
  return (Ints)_mm512_mask_i32gather_epi32(_mm512_setzero_si512(), 0xffff, (__m512i)i, base, 4);
#elif defined(__AVX2__)
  return (Ints)_mm256_i32gather_epi32(reinterpret_cast<const int*>(base), (__m256i)i, 4);
#else
  Ints bytes;
  for (int l = 0; l < lane_width; ++l) {
    std::int32_t four;
    memcpy(&four, base + 4 * static_cast<std::ptrdiff_t>(i[l]), sizeof four);
    bytes[l] = four;
  }
  return bytes;
#endif
}
OMMA_HD Pair<Ints> gather_pair(const std::int32_t* base, Ints i) {
  return gather_pairs_of_bits(base, i);
}
OMMA_HD Pair<Floats> gather_pair(const float* base, Ints i) {
  const Pair<Ints> bits = gather_pairs_of_bits(base, i);
  return {float_of(bits.first), float_of(bits.second)};
}

#if defined(__AVX2__)
// A quarter of each quad (k) of two vectors in turns, the second one's behind; the lower half of
// quads, or the upper one.
template <int... k>
OMMA_HD Floats mix_quads(Floats a, Floats b, bool upper, std::integer_sequence<int, k...>) {
  constexpr int low[] = {(k / 4 * 4 + k % 4 / 2 + k % 2 * lane_width)...};
  return upper ? shuffle(a, b, std::integer_sequence<int, (low[k] + 2)...>{})
               : shuffle(a, b, std::integer_sequence<int, low[k]...>{});
}
#endif
// A gather costs by the element; three neighbours lie in one load.
OMMA_HD void gather_3(const float* base, Ints index, Floats (&out)[3]) {
#if defined(__AVX2__)
  const auto sequence = std::make_integer_sequence<int, lane_width>{};
  // [k], of lanes k, 4 + k and so on a quad each.
  Floats quads[4];
  for (int k = 0; k < 4; ++k) {
    const auto load_lane = [&](int lane) {
      const float* at = base + 3 * static_cast<std::ptrdiff_t>(index[lane]);
#if defined(__AVX512F__)
      return _mm_maskz_loadu_ps(7, at);
#else
      return _mm_maskload_ps(at, _mm_setr_epi32(-1, -1, -1, 0));
#endif
    };
#if defined(__AVX512F__)
    const __m256 low =
        _mm256_insertf128_ps(_mm256_castps128_ps256(load_lane(k)), load_lane(k + 4), 1);
    const __m256 high =
        _mm256_insertf128_ps(_mm256_castps128_ps256(load_lane(k + 8)), load_lane(k + 12), 1);
    quads[k] = (Floats)_mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
#else
    quads[k] =
        (Floats)_mm256_insertf128_ps(_mm256_castps128_ps256(load_lane(k)), load_lane(k + 4), 1);
#endif
  }
  // x0 x2 y0 y2 and x1 x3 y1 y3 of each quad's lanes, then x0 x1 x2 x3.
  const Floats xy_even = mix_quads(quads[0], quads[2], false, sequence);
  const Floats xy_odd = mix_quads(quads[1], quads[3], false, sequence);
  const Floats z_even = mix_quads(quads[0], quads[2], true, sequence);
  const Floats z_odd = mix_quads(quads[1], quads[3], true, sequence);
  out[0] = mix_quads(xy_even, xy_odd, false, sequence);
  out[1] = mix_quads(xy_even, xy_odd, true, sequence);
  out[2] = mix_quads(z_even, z_odd, false, sequence);
#else
  const Pair<Ints> two = gather_two_of<3>(base, index);
  out[0] = float_of(two.first);
  out[1] = float_of(two.second);
  out[2] = gather(base + 2, index * 3);
#endif
}
OMMA_HD void gather_3(const std::int32_t* base, Ints index, Ints (&out)[3]) {
  Floats bits[3];
  gather_3(reinterpret_cast<const float*>(base), index, bits);
  for (int k = 0; k < 3; ++k) out[k] = bits_of(bits[k]);
}

OMMA_HD Floats pick(const float* p, Ints index) {
#if defined(__AVX512F__)
  return (Floats)_mm512_maskz_permutexvar_ps(0xffff, (__m512i)index, _mm512_loadu_ps(p));
#elif defined(__AVX2__)
  return (Floats)_mm256_permutevar8x32_ps(_mm256_loadu_ps(p), (__m256i)index);
#else
  return gather(p, index);
#endif
}

// The lanes whose bit is set, one behind the other from `to` on (stream compaction); what lies
// behind them there, up to a vector's width in all, is overwritten with anything.
template <typename T>
OMMA_HD void store_some(T* to, Floats x, unsigned bits) {
#if defined(__AVX512F__)
  const __m512 packed = _mm512_maskz_compress_ps(static_cast<__mmask16>(bits), (__m512)x);
  memcpy(to, &packed, sizeof packed);
#else
  for (; bits != 0; bits &= bits - 1) {
    const float lane = x[__builtin_ctz(bits)];
    memcpy(to++, &lane, sizeof lane);
  }
#endif
}
#endif

}  // namespace omma
