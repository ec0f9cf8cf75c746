// Independent directions around an axis, any number of lanes (kernel/lanes.h) at once: a hash, the
// radius of a pair of normals, the warp of kernel/acceptance.h, an azimuth. In floats: the polar
// angle is within a few 1e-7 of its value in doubles, relative to the acceptance angle.
#pragma once

#include "kernel/acceptance.h"
#include "kernel/hash.h"
#include "kernel/lanes.h"

namespace omma {

// Natural logarithm of a positive normal number: the mantissa in [sqrt(1/2), sqrt(2)) through the
// series of 2 artanh t, whose next term is below 1e-9.
template <typename F>
OMMA_HD F log_lanes(F x) {
  const auto bits = bits_of(x);
  const auto exponent = ((bits - 0x3f3504f3) >> 23);
  const F m = float_of(bits - (exponent << 23));
  const F t = (m - 1.0f) / (m + 1.0f), t2 = t * t;
  const F series = 2.0f + t2 * (0.66666667f + t2 * (0.4f + t2 * (0.28571429f + t2 * 0.22222222f)));
  return t * series + to_float(exponent) * 0.69314718f;
}

// Sine and cosine of an angle in [-pi, pi], from the Taylor series of the half angle: the first
// terms left out are below 7e-9.
template <typename F>
struct SineCosine {
  F sine, cosine;
};

template <typename F>
OMMA_HD SineCosine<F> sine_cosine(F angle_rad) {
  const F h = angle_rad * 0.5f, h2 = h * h;
  F s = 1.6059044e-10f * h2 - 2.5052108e-8f;
  s = s * h2 + 2.7557319e-6f;
  s = s * h2 - 1.9841270e-4f;
  s = s * h2 + 8.3333333e-3f;
  s = s * h2 - 1.6666667e-1f;
  s = h + h * (s * h2);
  F c = 2.0876757e-9f * h2 - 2.7557319e-7f;
  c = c * h2 + 2.4801587e-5f;
  c = c * h2 - 1.3888889e-3f;
  c = c * h2 + 4.1666667e-2f;
  c = c * h2 - 0.5f;
  c = 1.0f + c * h2;
  return {2.0f * s * c, c * c - s * s};
}

template <typename F>
struct LocalDirection {
  F x, y, z;  // z along the axis
};

// `polar`: [warp][AcceptanceWarpView::intervals + 1][theta, dtheta], as AcceptanceWarpView has
// them; `warp_begin`: where the warp's begin in it. `index`: number of the sample, `hash`: of its
// scramble.
template <typename F, typename I, typename U>
OMMA_HD LocalDirection<F> sample_random_direction(const float* polar, I warp_begin, U hash,
                                                  U index) {
  const U key = mix_bits_32(index ^ hash);
  const U first = mix_bits_32(key + 0x9e3779b9u), second = mix_bits_32(first ^ (hash + key));
  // In (0, 1), with all 32 bits where it is small, which is where the radius is large.
  const F u = to_float(int_of(first >> 16)) * 0x1p-16f +
              (to_float(int_of(first & 0xffffu)) + 0.5f) * 0x1p-32f;
  const F r = sqrt_lanes(-2.0f * log_lanes(u));
  constexpr auto knots_per_radius =
      static_cast<float>(AcceptanceWarpView::intervals / AcceptanceWarpView::r_max);
  const F knot = r * knots_per_radius;  // r is under 6.7, so this stays inside
  const I whole = to_int(knot), i = warp_begin + whole * 2;
  const F t = knot - to_float(whole), t2 = t * t, t3 = t2 * t;
  const F theta = gather(polar, i) * (2.0f * t3 - 3.0f * t2 + 1.0f) +
                  gather(polar, i + 1) * (t3 - 2.0f * t2 + t) +
                  gather(polar, i + 2) * (3.0f * t2 - 2.0f * t3) + gather(polar, i + 3) * (t3 - t2);
  // (-1, 1) pi, from the upper 24 bits.
  const F azimuth = (to_float(int_of(second >> 8)) + 0.5f) * (0x1p-23f * 3.14159265f) - 3.14159265f;
  const SineCosine<F> p = sine_cosine(theta), a = sine_cosine(azimuth);
  return {p.sine * a.cosine, p.sine * a.sine, p.cosine};
}

}  // namespace omma
