// Powers of numbers in lanes, of arithmetic alone: functions of libm differ between processors.
#pragma once

#include "physics/lanes/lanes.h"

namespace omma {

// 2^x for |x| < 126, to 2e-7 of it: the whole part by the exponent, the rest, within 1/2, by the
// series of the exponential function.
template <typename F>
OMMA_HD F exp2_lanes(F x) {
  const F whole = floor_lanes(x + 0.5f);
  const F y = (x - whole) * 0.693147181f;
  F sum = broadcast<F>(1.0f / 5040);
  sum = sum * y + 1.0f / 720;
  sum = sum * y + 1.0f / 120;
  sum = sum * y + 1.0f / 24;
  sum = sum * y + 1.0f / 6;
  sum = sum * y + 0.5f;
  sum = sum * y + 1.0f;
  sum = sum * y + 1.0f;
  return sum * float_of((to_int(whole) + 127) << 23);
}

// Beyond this optical depth, 10^-26, no more is hidden: so what is left can be divided by.
inline constexpr float greatest_depth = 60.0f;

// exp(-x), 0 <= x <= greatest_depth, within 2 units in the last place; the same steps for one lane
// and for many, as a library's function differs between processors. x = k ln 2 + f (Cody and Waite
// 1980), and of exp(-f), |f| <= ln 2 / 2, the series to the seventh power, which errs by 10^-8.
template <typename F>
OMMA_HD F exp_minus(F x) {
  const F k = floor_lanes(x * 1.44269504f + 0.5f);
  const F f = (x - k * 0.693359375f) + k * 2.12194440e-4f;
  F sum = broadcast<F>(1.0f);
  for (int n = 7; n > 0; --n) sum = 1.0f - sum * f * (1.0f / static_cast<float>(n));
  return sum * float_of((127 - to_int(k)) << 23);
}

// The same of any depth of 0 or more, at most greatest_depth of which count.
template <typename F>
OMMA_HD F left_by_depth(F depth) {
  return exp_minus(depth < greatest_depth ? depth : broadcast<F>(greatest_depth));
}

// log2(x) of normal numbers above 0, to 2e-7 of it or of 1: the exponent, and the logarithm of the
// rest m, within 1/√2 and √2, by the series of artanh((m − 1) / (m + 1)).
template <typename F>
OMMA_HD F log2_lanes(F x) {
  // As many steps above √(1/2), 0x3f3504f3, as the number has.
  const auto exponent = (bits_of(x) - 0x3f3504f3) >> 23;
  const F m = float_of(bits_of(x) - (exponent << 23));
  const F s = (m - 1.0f) / (m + 1.0f), square = s * s;
  F sum = broadcast<F>(1.0f / 9);
  sum = sum * square + 1.0f / 7;
  sum = sum * square + 1.0f / 5;
  sum = sum * square + 1.0f / 3;
  sum = sum * square + 1.0f;
  return to_float(exponent) + sum * s * 2.88539008f;
}

// Linear light of an sRGB value of 0 or more; the curve goes on above 1 (IEC 61966-2-1).
template <typename F>
OMMA_HD F linear_of_srgb(F value) {
  const F above = value > 0.04045f ? value : broadcast<F>(0.04045f);
  const F power = exp2_lanes(log2_lanes((above + 0.055f) * (1.0f / 1.055f)) * 2.4f);
  return value > 0.04045f ? power : value * (1.0f / 12.92f);
}

}  // namespace omma
