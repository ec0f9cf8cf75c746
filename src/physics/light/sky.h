// The sky as a map of nodes: where a direction is looked up among them, what comes from there, and
// directions sampled in its cells or in discs. Stokes vectors in the frame of omma/light.h.
// Distances in angle are found without the C library, so that all instruction sets give the same
// bits.
#pragma once

#include "physics/lanes/vector3.h"
#include "physics/sampling/cumulative.h"
#include "physics/sampling/random_direction.h"
#include "physics/views/light_view.h"

namespace omma {

// The angle from x towards y of a point with x, y >= 0, within 2e-7 rad: atan of an argument below
// tan(pi/8) as a polynomial (minimax, 5e-9); beyond it by the angle from the diagonal.
template <typename F>
OMMA_HD F angle_in_quadrant(F x, F y) {
  const F small = x < y ? x : y, large = x < y ? y : x;
  const auto near_diagonal = small > 0.41421356f * large;
  const F over = near_diagonal ? small - large : small;
  const F under = near_diagonal ? small + large : large;
  const F t = over / (under > 1e-37f ? under : broadcast<F>(1e-37f)), t2 = t * t;
  F p = 0.0790005287f * t2 - 0.138236603f;
  p = p * t2 + 0.199718037f;
  p = p * t2 - 0.333327546f;
  const F angle = keep(near_diagonal, broadcast<F>(0.785398163f)) + (t + t * t2 * p);
  return y > x ? 1.57079633f - angle : angle;
}

// Where directions are looked up among the nodes of a sky.
template <typename F, typename I>
struct SkyLookup {
  I half = {};  // 0: above the horizon, and the horizon itself; 1: below
  // Nodes at or before it, the column to the right, and how far on to the next row and column, 0
  // to 1.
  I row = {}, column = {}, next = {};
  F along_row = {}, along_column = {};
};
using OneSkyLookup = SkyLookup<float, std::int32_t>;

template <typename F>
OMMA_HD auto find_on_sky(const SkyView& sky, F x, F y, F z) {
  using I = decltype(to_int(x));
  const auto size = [](F value) { return value < 0.0f ? 0.0f - value : value; };
  SkyLookup<F, I> place;
  const I one = to_int(broadcast<F>(1.0f));
  place.half = keep(y < 0.0f, one);
  const F row = angle_in_quadrant(sqrt_lanes(x * x + z * z), size(y)) * sky.rows_per_rad;
  const I last_row = one * (sky.rows - 2), last_column = one * (sky.columns - 1);
  place.row = to_int(row);
  place.row = place.row > last_row ? last_row : place.row;
  const F along_row = row - to_float(place.row);
  place.along_row = along_row < 1.0f ? along_row : broadcast<F>(1.0f);

  const F turned = angle_in_quadrant(size(z), size(x));
  const F azimuth = z > 0.0f ? 3.14159265f - turned : turned;
  F column = (x < 0.0f ? 6.28318531f - azimuth : azimuth) * sky.columns_per_rad;
  const F all = to_float(last_column + one);
  column = column > 0.0f ? column : broadcast<F>(0.0f);
  column = column < all ? column : all;
  place.column = to_int(column);
  place.column = place.column > last_column ? last_column : place.column;
  place.along_column = column - to_float(place.column);
  place.next = keep(place.column < last_column, place.column + one);
  return place;
}

// Between columns as far apart as 360 of them are, or less, axes are not turned: of a polarisation
// that is one all about the zenith 2 pi^2 / columns^2 is lost at most, 1.5e-4.
inline constexpr int even_columns = 360;

// Where Stokes vectors of all bands go: `components` 1 (I) or 3 (I, Q, U), at
// stokes[component * component_stride + band * band_stride].
struct StokesOut {
  float* stokes;
  int components, band_stride, component_stride;
};

// Radiance of the sky at the place of one direction, for any sky: channels that are not bands,
// axes that turn from node to node.
OMMA_HD_LARGE void eval_sky(const LightView& light, Vec3 d, const OneSkyLookup& place,
                            const StokesOut& to) {
  const SkyView& sky = light.sky;
  const int channels = sky.channels;
  const std::ptrdiff_t row = (static_cast<std::ptrdiff_t>(place.half) * sky.rows + place.row);
  const std::ptrdiff_t first = row * sky.columns;
  const float right = place.along_column, up = place.along_row;
  const float high = up * sky.per_unit, low = (1.0f - up) * sky.per_unit;
  const float wa = (1.0f - right) * low, wb = right * low, wc = (1.0f - right) * high,
              we = right * high;
  alignas(64) float mixed[most_bands];
  const auto put = [&](int component) {
    float* out = to.stokes + component * to.component_stride;
    if (sky.band_from_channel == nullptr) {
      for (int k = 0; k < channels; ++k) out[k * to.band_stride] = mixed[k];
      return;
    }
    for (int k = 0; k < light.bands; ++k) {
      const float* weights = sky.band_from_channel + k * channels;
      float sum = 0;
      for (int i = 0; i < channels; ++i) sum += weights[i] * mixed[i];
      out[k * to.band_stride] = sum;
    }
  };
  {
    const float* a = sky.radiance + (first + place.column) * channels;
    const float* b = sky.radiance + (first + place.next) * channels;
    const std::ptrdiff_t next = static_cast<std::ptrdiff_t>(sky.columns) * channels;
    const float *c = a + next, *e = b + next;
    for (int k = 0; k < channels; ++k) mixed[k] = wa * a[k] + wb * b[k] + wc * c[k] + we * e[k];
    put(0);
  }
  if (to.components == 1) return;
  if (sky.polarisation == nullptr) {
    for (int p = 1; p < 3; ++p)
      for (int k = 0; k < light.bands; ++k)
        to.stokes[p * to.component_stride + k * to.band_stride] = 0;
    return;
  }
  const float* a = sky.polarisation + (first + place.column) * 2 * channels;
  const float* b = sky.polarisation + (first + place.next) * 2 * channels;
  const std::ptrdiff_t next = static_cast<std::ptrdiff_t>(sky.columns) * 2 * channels;
  const float *c = a + next, *e = b + next;
  if (!sky.turns_axes) {
    for (int p = 0; p < 2; ++p) {
      const int of = p * channels;
      for (int k = 0; k < channels; ++k)
        mixed[k] = wa * a[of + k] + wb * b[of + k] + wc * c[of + k] + we * e[of + k];
      put(1 + p);
    }
    return;
  }
  // Each node has a reference axis of its own. Carried to the direction without being turned, along
  // a circle of elevation, it lies beside the direction's own by the azimuth between them times the
  // sine of elevation: wholly at the zenith, not at all at the horizon. Left alone, what is one
  // polarisation all about the zenith would lose some of its degree between columns.
  const float turn = 2.0f * d.y / sky.columns_per_rad;
  const SineCosine<float> from_left = sine_cosine(turn * right);
  const SineCosine<float> from_right = sine_cosine(turn * (right - 1.0f));
  const float ca = wa * from_left.cosine, sa = wa * from_left.sine;
  const float cc = wc * from_left.cosine, sc = wc * from_left.sine;
  const float cb = wb * from_right.cosine, sb = wb * from_right.sine;
  const float ce = we * from_right.cosine, se = we * from_right.sine;
  const int u = channels;
  for (int k = 0; k < channels; ++k)
    mixed[k] = (ca * a[k] - sa * a[u + k]) + (cb * b[k] - sb * b[u + k]) +
               (cc * c[k] - sc * c[u + k]) + (ce * e[k] - se * e[u + k]);
  put(1);
  for (int k = 0; k < channels; ++k)
    mixed[k] = (sa * a[k] + ca * a[u + k]) + (sb * b[k] + cb * b[u + k]) +
               (sc * c[k] + cc * c[u + k]) + (se * e[k] + ce * e[u + k]);
  put(2);
}

// A direction in a cell of the sky, evenly by solid angle, of u0 and u1 in [0, 1).
template <typename F>
OMMA_HD Vector3<F> sample_sky(const SkyView& sky, F u0, F u1) {
  using I = decltype(to_int(u0));
  const std::int32_t cell_rows = sky.rows - 1;
  const I zero = to_int(F{});
  const I row = find_in_sum(sky.row_sum, zero, sky.row_guide, zero, 2 * cell_rows, u0);
  const I first = row * (sky.columns + 1);
  const I column =
      find_in_sum(sky.column_sum, first, sky.column_guide, row * sky.columns, sky.columns, u1);
  const F along_row = within_part(gather(sky.row_sum, row), gather(sky.row_sum, row + 1), u0);
  const I at = first + column;
  const F along_column =
      within_part(gather(sky.column_sum, at), gather(sky.column_sum, at + 1), u1);
  const auto below = row >= cell_rows;
  const I level = row - keep(below, zero + cell_rows);
  // One minus the sine of elevation keeps its digits at the zenith.
  const F here = gather(sky.one_minus_sine, level), next = gather(sky.one_minus_sine, level + 1);
  const F k = here + along_row * (next - here), least = broadcast<F>(0x1p-25f);
  F sine = 1.0f - k;
  sine = sine > least ? sine : least;  // not 0, so that below stays below
  const F cosine = sqrt_lanes(k * (2.0f - k));
  F azimuth = (to_float(column) + along_column) / sky.columns_per_rad;
  azimuth = azimuth > 3.14159265f ? azimuth - 6.28318531f : azimuth;
  const SineCosine<F> turn = sine_cosine(azimuth);
  return {turn.sine * cosine, below ? 0.0f - sine : sine, (0.0f - turn.cosine) * cosine};
}

// A direction in a disc, evenly by solid angle.
template <typename F>
OMMA_HD Vector3<F> sample_disc(const DiscView& disc, F u0, F u1) {
  const Vector3<float> n = vector_of(disc.direction);
  const Axes<float> axes = make_axes(n);
  const F chord = u0 * disc.chord_2;
  const F sine = sqrt_lanes(chord * (1.0f - 0.25f * chord));
  const SineCosine<F> turn = sine_cosine((2.0f * u1 - 1.0f) * 3.14159265f);
  return n * (1.0f - 0.5f * chord) +
         (axes.tangent * turn.cosine + axes.bitangent * turn.sine) * sine;
}

}  // namespace omma
