// Independent directions around an axis, any number of lanes (physics/lanes/lanes.h) at once: a hash, the
// radius of a pair of normals, the warp of physics/sampling/acceptance_sampling.h, an azimuth. In floats:
// the polar angle is within a few 1e-7 of its value in doubles, relative to the acceptance angle.
#pragma once

#include "physics/lanes/lanes.h"
#include "physics/sampling/acceptance_sampling.h"
#include "physics/sampling/hash.h"

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

// The rows of theta(r) of all warps in floats, all with the same number of intervals; made by
// sampling/polar_tables.
struct PolarTablesView {
  int intervals = 0;
  const float* polar = nullptr;  // [row][intervals + 1][theta, dtheta], as AcceptanceWarpView
  // Where all are round, row w is that of warp w, and this is null. Else, for each warp, where its
  // part of `azimuth` begins ([part][AcceptanceWarpView::azimuths + 1][azimuth in rad, row]) and
  // the first of its rows.
  const float* azimuth = nullptr;
  const std::int32_t* azimuth_begin = nullptr;  // [warp]
  const std::int32_t* first_row = nullptr;      // [warp]
  int rows = 0, azimuth_parts = 0, warps = 0;   // rows: with the one that is read behind the last
};

// `begin`: where a row begins in `polar`; `knot`: the radius in knots.
template <typename F, typename I>
OMMA_HD F polar_angle_lanes(const float* polar, I begin, F knot) {
  const I whole = to_int(knot), i = begin + whole * 2;
  const F t = knot - to_float(whole), t2 = t * t, t3 = t2 * t;
  return gather(polar, i) * (2.0f * t3 - 3.0f * t2 + 1.0f) +
         gather(polar, i + 1) * (t3 - 2.0f * t2 + t) +
         gather(polar, i + 2) * (3.0f * t2 - 2.0f * t3) + gather(polar, i + 3) * (t3 - t2);
}

// `warp`: index of the warp; `index`: number of the sample, `hash`: of its scramble.
template <typename F, typename I, typename U>
OMMA_HD LocalDirection<F> sample_random_direction(const PolarTablesView& tables, I warp, U hash,
                                                  U index) {
  const U key = mix_bits_32(index ^ hash);
  const U first = mix_bits_32(key + 0x9e3779b9u), second = mix_bits_32(first ^ (hash + key));
  // In (0, 1), with all 32 bits where it is small, which is where the radius is large.
  const F u = to_float(int_of(first >> 16)) * 0x1p-16f +
              (to_float(int_of(first & 0xffffu)) + 0.5f) * 0x1p-32f;
  const F r = sqrt_lanes(-2.0f * log_lanes(u));
  const auto knots_per_radius = static_cast<float>(tables.intervals / AcceptanceWarpView::r_max);
  const F knot = r * knots_per_radius;  // r is under 6.7, so this stays inside
  const int stride = 2 * (tables.intervals + 1);
  // (-1, 1) pi, from the upper 24 bits.
  F azimuth = (to_float(int_of(second >> 8)) + 0.5f) * (0x1p-23f * 3.14159265f) - 3.14159265f;
  F theta;
  if (tables.azimuth == nullptr) {
    theta = polar_angle_lanes(tables.polar, warp * stride, knot);
  } else {
    const F x = (to_float(int_of(second >> 8)) + 0.5f) *
                (0x1p-24f * static_cast<float>(AcceptanceWarpView::azimuths));
    constexpr int last = AcceptanceWarpView::azimuths - 1;
    I whole = to_int(x);
    whole = whole > last ? whole * 0 + last : whole;  // x may have been rounded up
    const I i = gather(tables.azimuth_begin, warp) + whole * 2;
    const F t = x - to_float(whole);
    azimuth = gather(tables.azimuth, i) * (1.0f - t) + gather(tables.azimuth, i + 2) * t;
    azimuth = azimuth > 3.14159265f ? azimuth - 6.28318531f : azimuth;
    const F place = gather(tables.azimuth, i + 1) * (1.0f - t) + gather(tables.azimuth, i + 3) * t;
    const I row = to_int(place);
    const I begin = (gather(tables.first_row, warp) + row) * stride;
    const F before = polar_angle_lanes(tables.polar, begin, knot);
    const F after = polar_angle_lanes(tables.polar, begin + stride, knot);
    theta = before + (place - to_float(row)) * (after - before);
  }
  const SineCosine<F> p = sine_cosine(theta), a = sine_cosine(azimuth);
  return {p.sine * a.cosine, p.sine * a.sine, p.cosine};
}

}  // namespace omma
