// Intervals chosen by their share of a cumulative sum.
#pragma once

#include <cstdint>

#include "physics/lanes/lanes.h"

namespace omma {

// Which of the intervals of `sum`, [count + 1] ascending from 0 to 1, holds u: never one without
// width.
OMMA_HD std::int32_t find_in_sum(const float* sum, std::int32_t count, float u) {
  std::int32_t first = 0;
  while (count > 1) {
    const std::int32_t half = count / 2;
    first = sum[first + half] <= u ? first + half : first;
    count -= half;
  }
  return first;
}

// The same from what is known of j / count, j the whole part of u count: a step or two on average
// however many intervals there are (the method of cutpoints, Chen and Asau 1974). Tables of lanes
// begin at `first` and `first_guide`.
template <typename F, typename I>
OMMA_HD I find_in_sum(const float* sum, I first, const std::uint16_t* guide, I first_guide,
                      std::int32_t count, F u) {
  I j = to_int(u * to_float(count));
  j = j < count ? j : j * 0 + (count - 1);
  const I at = first_guide + j;
  // Two of 16 bits are read at once.
  const I pair = gather_bytes(reinterpret_cast<const std::uint8_t*>(guide), at >> 1);
  I i = (pair >> ((at & 1) * 16)) & 0xffff;
  for (;;) {
    const auto is_before = gather(sum, first + i + 1) <= u;
    if (!any_lane(is_before)) return i;
    i = i + keep(is_before, i * 0 + 1);
  }
}

// u within the interval of numbers a to b that it lies in, in [0, 1).
template <typename F>
OMMA_HD F within_part(F a, F b, F u) {
  const F inside = (u - a) / (b - a), most = broadcast<F>(0x1.fffffep-1f);
  const F at_least = inside > 0.0f ? inside : broadcast<F>(0.0f);
  return at_least < most ? at_least : most;
}
OMMA_HD float within_part(const float* sum, std::int32_t interval, float u) {
  return within_part(sum[interval], sum[interval + 1], u);
}

}  // namespace omma
