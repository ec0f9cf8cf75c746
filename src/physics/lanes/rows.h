// Rows and columns: tables with a row for each lane become [column][lane] (a transpose), rows of
// numbers become lanes, a packet's lanes are summed up.
#pragma once

#include <type_traits>

#include "physics/lanes/lanes.h"

namespace omma {

// Rows become columns: element [i][k] goes to [k][i].
#if !defined(__CUDACC__)
template <int step, int... k>
OMMA_HD void swap_halves(Floats& a, Floats& b, std::integer_sequence<int, k...>) {
  constexpr auto of_first =
      std::integer_sequence<int, ((k & step) == 0 ? k : lane_width + k - step)...>{};
  constexpr auto of_second =
      std::integer_sequence<int, ((k & step) == 0 ? k + step : lane_width + k)...>{};
  const Floats first = shuffle(a, b, of_first), second = shuffle(a, b, of_second);
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

// As many neighbours in memory as lanes go at once, or `count` of them and zeros: floats, or
// numbers of 16 bits.
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

// A masked transpose: the row of each lane in `lanes` (bits of the lanes that go at once) becomes a
// column of `out` [column][lane], zeros in the other lanes. `row(k, read)` gives lane k's row, a
// vector of columns at a time, where `read(p)` loads them from the row of a table that begins at p.
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

}  // namespace omma
