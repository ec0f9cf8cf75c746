// The physics is written once for any number of lanes: `F` is a float (one ray: device code, filters,
// tests) or a vector of floats (a processor's packets, `Floats`), `I` and `U` the integers beside it.
// Arithmetic, comparisons and `mask ? a : b` read the same for both; what differs is here.
//
// A packet of rays lies in memory as [lane] (ray_packet.h) and goes through the arithmetic some
// lanes at a time; Lanes says how many there are and how many go at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

#include "omma/vec.h"
#if defined(__AVX2__) && !defined(__CUDACC__)
#include <immintrin.h>
#endif

namespace omma {

// Linear RGBA, or a weight for each.
template <typename F>
struct Color {
  F r, g, b, a;
};

template <typename F>
OMMA_HD Color<F> operator+(const Color<F>& p, const Color<F>& q) {
  return {p.r + q.r, p.g + q.g, p.b + q.b, p.a + q.a};
}
template <typename F>
OMMA_HD Color<F> operator*(const Color<F>& p, const Color<F>& q) {
  return {p.r * q.r, p.g * q.g, p.b * q.b, p.a * q.a};
}
template <typename F>
OMMA_HD Color<F> operator*(const Color<F>& p, F s) {
  return {p.r * s, p.g * s, p.b * s, p.a * s};
}

// Two neighbours in memory, for each lane.
template <typename T>
struct Pair {
  T first, second;
};

template <typename F>
OMMA_HD F broadcast(float x) {
  return F{} + x;
}

// Lanes that lie in memory one behind the other; T is a lane's type, or any of that size.
template <typename Vector, typename T>
OMMA_HD Vector load(const T* p) {
  Vector v;
  memcpy(&v, p, sizeof v);
  return v;
}
template <typename Vector, typename T>
OMMA_HD void store(T* p, Vector v) {
  memcpy(p, &v, sizeof v);
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
// Four bytes from 4 * index on, the first lowest.
OMMA_HD std::int32_t gather_bytes(const std::uint8_t* base, std::int32_t index) {
  const std::uint8_t* at = base + 4 * static_cast<std::ptrdiff_t>(index);
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

// Of the elements of a and those of b behind them: the ones at even places, and at odd ones.
template <int... k>
OMMA_HD Pair<Ints> every_second(Ints a, Ints b, std::integer_sequence<int, k...>) {
#if defined(__clang__) || __GNUC__ >= 12
  return {__builtin_shufflevector(a, b, (2 * k)...), __builtin_shufflevector(a, b, (2 * k + 1)...)};
#else  // GCC 11 knows the same under another name
  return {__builtin_shuffle(a, b, Ints{(2 * k)...}), __builtin_shuffle(a, b, Ints{(2 * k + 1)...})};
#endif
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
OMMA_HD Pair<Ints> gather_pairs_of_bits(const void* base, Ints i) {
  const auto pair = [&](int lane) {
    std::int64_t bits;
    memcpy(&bits, static_cast<const char*>(base) + 8 * static_cast<std::ptrdiff_t>(i[lane]), 8);
    return bits;
  };
  using Wide = std::int64_t __attribute__((vector_size(16)));
  const Ints a = (Ints)Wide{pair(0), pair(1)}, b = (Ints)Wide{pair(2), pair(3)};
  return every_second(a, b, std::make_integer_sequence<int, lane_width>{});
}
#endif
OMMA_HD Ints gather_bytes(const std::uint8_t* base, Ints i) {
#if defined(__AVX512F__)
  return (Ints)_mm512_mask_i32gather_epi32(_mm512_setzero_si512(), 0xffff, (__m512i)i, base, 4);
#elif defined(__AVX2__)
  return (Ints)_mm256_i32gather_epi32(reinterpret_cast<const int*>(base), (__m256i)i, 4);
#else
  return Ints{gather_bytes(base, i[0]), gather_bytes(base, i[1]), gather_bytes(base, i[2]),
              gather_bytes(base, i[3])};
#endif
}
OMMA_HD Pair<Ints> gather_pair(const std::int32_t* base, Ints i) {
  return gather_pairs_of_bits(base, i);
}
OMMA_HD Pair<Floats> gather_pair(const float* base, Ints i) {
  const Pair<Ints> bits = gather_pairs_of_bits(base, i);
  return {float_of(bits.first), float_of(bits.second)};
}
#endif

// base[3 * index] and the two behind it, for each lane.
template <typename T>
OMMA_HD void gather_3(const T* base, std::int32_t index, T (&out)[3]) {
  for (int k = 0; k < 3; ++k) out[k] = base[3 * static_cast<std::ptrdiff_t>(index) + k];
}
#if !defined(__CUDACC__)
#if defined(__AVX2__)
// A quarter of each quad (k) of two vectors in turns, the second one's behind; the lower half of
// quads, or the upper one.
template <int... k>
OMMA_HD Floats mix_quads(Floats a, Floats b, bool upper, std::integer_sequence<int, k...>) {
#if defined(__clang__) || __GNUC__ >= 12
  const Floats low =
      __builtin_shufflevector(a, b, (k / 4 * 4 + k % 4 / 2 + k % 2 * lane_width)...);
  const Floats high =
      __builtin_shufflevector(a, b, (k / 4 * 4 + 2 + k % 4 / 2 + k % 2 * lane_width)...);
#else  // GCC 11 knows the same under another name
  const Floats low =
      __builtin_shuffle(a, b, Ints{(k / 4 * 4 + k % 4 / 2 + k % 2 * lane_width)...});
  const Floats high =
      __builtin_shuffle(a, b, Ints{(k / 4 * 4 + 2 + k % 4 / 2 + k % 2 * lane_width)...});
#endif
  return upper ? high : low;
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
    const __m256 low = _mm256_insertf128_ps(_mm256_castps128_ps256(load_lane(k)), load_lane(k + 4), 1);
    const __m256 high =
        _mm256_insertf128_ps(_mm256_castps128_ps256(load_lane(k + 8)), load_lane(k + 12), 1);
    quads[k] = (Floats)_mm512_insertf32x8(_mm512_castps256_ps512(low), high, 1);
#else
    quads[k] = (Floats)_mm256_insertf128_ps(_mm256_castps128_ps256(load_lane(k)), load_lane(k + 4), 1);
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
  for (int k = 0; k < 3; ++k) out[k] = gather(base + k, index * 3);
#endif
}
OMMA_HD void gather_3(const std::int32_t* base, Ints index, Ints (&out)[3]) {
  Floats bits[3];
  gather_3(reinterpret_cast<const float*>(base), index, bits);
  for (int k = 0; k < 3; ++k) out[k] = bits_of(bits[k]);
}
#endif

#if !defined(__CUDACC__)
OMMA_HD Floats pick(const float* p, Ints index) {
#if defined(__AVX512F__)
  return (Floats)_mm512_maskz_permutexvar_ps(0xffff, (__m512i)index, (__m512)load<Floats>(p));
#elif defined(__AVX2__)
  return (Floats)_mm256_permutevar8x32_ps((__m256)load<Floats>(p), (__m256i)index);
#else
  return gather(p, index);
#endif
}
#endif

// The lanes whose bit is set, one behind the other from `to` on; what lies behind them there, up to
// a vector's width in all, is overwritten with anything.
#if !defined(__CUDACC__)
template <typename T>
OMMA_HD void store_some(T* to, Floats x, unsigned bits) {
#if defined(__AVX512F__)
  store(to, (Floats)_mm512_maskz_compress_ps(static_cast<__mmask16>(bits), (__m512)x));
#else
  for (; bits != 0; bits &= bits - 1) store(to++, x[__builtin_ctz(bits)]);
#endif
}
#endif
template <typename T>
OMMA_HD void store_some(T* to, float x, unsigned bits) {
  if (bits != 0) store(to, x);
}

// Rows become columns: element [i][k] goes to [k][i].
#if !defined(__CUDACC__)
template <int step, int... k>
OMMA_HD void swap_halves(Floats& a, Floats& b, std::integer_sequence<int, k...>) {
#if defined(__clang__) || __GNUC__ >= 12
  const Floats first =
      __builtin_shufflevector(a, b, ((k & step) == 0 ? k : lane_width + k - step)...);
  const Floats second =
      __builtin_shufflevector(a, b, ((k & step) == 0 ? k + step : lane_width + k)...);
#else  // GCC 11 knows the same under another name
  const Floats first =
      __builtin_shuffle(a, b, Ints{((k & step) == 0 ? k : lane_width + k - step)...});
  const Floats second =
      __builtin_shuffle(a, b, Ints{((k & step) == 0 ? k + step : lane_width + k)...});
#endif
  a = first;
  b = second;
}
template <int step>
OMMA_HD void swap_halves(Floats (&rows)[lane_width]) {
  for (int i = 0; i < lane_width; ++i)
    if ((i & step) == 0)
      swap_halves<step>(rows[i], rows[i + step], std::make_integer_sequence<int, lane_width>{});
}
OMMA_HD void transpose(Floats (&rows)[lane_width]) {
  swap_halves<1>(rows);
  swap_halves<2>(rows);
  if constexpr (lane_width > 4) swap_halves<4>(rows);
  if constexpr (lane_width > 8) swap_halves<8>(rows);
}
#endif
OMMA_HD void transpose(float (&)[1]) {}

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

// Whether any of a packet's lanes is on; the bits of a mask [lane] of 0 and -1.
template <typename L>
OMMA_HD unsigned packet_bits(const std::int32_t* mask) {
  unsigned bits = 0;
  for (int l = 0; l < L::count; l += L::width)
    bits |= lane_bits(load<typename L::I>(mask + l) != 0) << l;
  return bits;
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

template <typename F, int n>
OMMA_HD void load_3(const float (&values)[3][n], int l, F (&out)[3]) {
  for (int r = 0; r < 3; ++r) out[r] = load<F>(values[r] + l);
}

// A comparison's result that holds for the lanes from l on whose bit is set.
template <typename L>
OMMA_HD auto lanes_on(unsigned bits, int l) {
  const auto word = lane_numbers<L>() * 0 + static_cast<std::int32_t>(bits >> l);
  return (word >> lane_numbers<L>() & 1) != 0;
}

// Numbers of 16 bits that are neighbours in memory; the second argument says how many.
OMMA_HD std::int32_t widen(const std::uint16_t* p, std::int32_t) {
  return *p;
}
#if !defined(__CUDACC__)
OMMA_HD Ints widen(const std::uint16_t* p, Ints) {
  using Shorts = std::uint16_t __attribute__((vector_size(2 * lane_width)));
  return __builtin_convertvector(load<Shorts>(p), Ints);
}
#endif

// As many neighbours in memory as lanes go at once, or `count` of them and zeros: floats, or numbers
// of 16 bits.
template <typename L, typename T>
OMMA_HD auto load_row(const T* p, int count) {
  using F = typename L::F;
  using I = typename L::I;
  constexpr bool is_float = std::is_same_v<T, float>;
  alignas(L::width * 4) T some[L::width] = {};
  if (count < L::width) {
    for (int i = 0; i < count; ++i) some[i] = p[i];
    p = some;
  }
  if constexpr (is_float)
    return load<F>(p);
  else
    return widen(p, I{});
}

// Tables with a row for each lane, [row][column], as [column][lane] from `out` on: of lanes that go at
// once those in `lanes`, whose other bits do not count, and zeros in the others. `row(k, read)` gives
// what lane k has, in which `read(p)` stands for what p points to, the first of a row's numbers in a
// table.
template <typename L, typename Row>
OMMA_HD void store_rows(int columns, unsigned lanes, const Row& row, float* out) {
  using F = typename L::F;
  constexpr int width = L::width;
  for (int first = 0; first < columns; first += width) {
    const int left = columns - first;
    F rows[width] = {};
    for (unsigned bits = lanes & ((1u << width) - 1u); bits != 0; bits &= bits - 1) {
      const int k = lowest_bit(bits);
      rows[k] = row(k, [&](const auto* p) { return load_row<L>(p + first, left); });
    }
    transpose(rows);
    for (int k = 0; k < width && k < left; ++k) store(out + (first + k) * L::count, rows[k]);
  }
}

// The sum of a packet's lanes, always in the same order: of sixteen, lanes 4 apart first.
template <typename L>
OMMA_HD float sum_lanes(const float* x) {
  if constexpr (L::count == 1) {
    return x[0];
  } else {
    static_assert(L::count == 16);
    float quad[4];
#if !defined(__CUDACC__)
    using Quad = float __attribute__((vector_size(16)));
    store(quad, (load<Quad>(x) + load<Quad>(x + 8)) + (load<Quad>(x + 4) + load<Quad>(x + 12)));
#else
    for (int k = 0; k < 4; ++k) quad[k] = (x[k] + x[k + 8]) + (x[k + 4] + x[k + 12]);
#endif
    return (quad[0] + quad[1]) + (quad[2] + quad[3]);
  }
}

// The greatest integer not above x, |x| < 2^31; the same steps for one lane and for many.
template <typename F>
OMMA_HD F floor_lanes(F x) {
  const F towards_zero = to_float(to_int(x));
  return towards_zero > x ? towards_zero - 1.0f : towards_zero;
}

// Of vectors.
template <typename F>
OMMA_HD F dot_lanes(const F (&a)[3], const F (&b)[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <typename F>
OMMA_HD void cross_lanes(const F (&a)[3], const F (&b)[3], F (&out)[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

// Into [0, 1]. Comparisons, not fminf and fmaxf, which compilers may turn into calls.
template <typename F>
OMMA_HD F clamp_unit_lanes(F x) {
  x = x > 0.0f ? x : broadcast<F>(0.0f);
  return x < 1.0f ? x : broadcast<F>(1.0f);
}

}  // namespace omma
