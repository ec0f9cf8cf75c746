// Light from afar for the lanes of a packet: discs such as the sun, and directions in them, all lanes
// at once; the sky, whose maps are read lane by lane.
#pragma once

#include "physics/light_sample.h"

namespace omma {

template <int n>
OMMA_HD Vec3 vec_at(const float (&values)[3][n], int l) {
  return {values[0][l], values[1][l], values[2][l]};
}

template <typename F>
OMMA_HD F chord_2_lanes(const F (&d)[3], Vec3 centre) {
  const F x = d[0] - centre.x, y = d[1] - centre.y, z = d[2] - centre.z;
  return x * x + y * y + z * z;
}

// Where light from afar of some lanes' directions is to be looked up, and asked for; all before the
// first is read.
template <typename L>
OMMA_HD void find_far_lanes(const LightView& light, const float (&direction)[3][L::count],
                            unsigned lanes, int components, SkyPlace (&places)[L::count]) {
  using F = typename L::F;
  constexpr int n = L::count;
  if (light.sky.rows == 0) return;
  for (int l = 0; l < n; l += L::width) {
    if ((lanes >> l & ((1u << L::width) - 1u)) == 0) continue;
    F d[3];
    load_3(direction, l, d);
    const auto found = find_on_sky(light.sky, d[0], d[1], d[2]);
    alignas(L::width * 4) std::int32_t half[L::width], row[L::width], column[L::width],
        next[L::width];
    alignas(L::width * 4) float along_row[L::width], along_column[L::width];
    store(half, found.half);
    store(row, found.row);
    store(column, found.column);
    store(next, found.next);
    store(along_row, found.along_row);
    store(along_column, found.along_column);
    for (int k = 0; k < L::width; ++k) {
      if ((lanes >> (l + k) & 1u) == 0) continue;
      places[l + k] = {half[k], row[k], column[k], next[k], along_row[k], along_column[k]};
      fetch_sky(light.sky, places[l + k], components);
    }
  }
}

// Adds the radiance of discs in the directions of some lanes to `out` [band][lane]; as add_discs.
template <typename L>
OMMA_HD void add_disc_light(const LightView& light, const float (&direction)[3][L::count],
                            unsigned lanes, float* out) {
  using F = typename L::F;
  for (int i = 0; i < light.disc_count; ++i) {
    const DiscView& disc = light.discs[i];
    for (int l = 0; l < L::count; l += L::width) {
      F d[3];
      load_3(direction, l, d);
      const F chord = chord_2_lanes(d, disc.direction);
      const auto inside = lanes_on<L>(lanes, l) && chord <= disc.chord_2;
      if (!any_lane(inside)) continue;
      F darkened{};
      if (disc.limb != nullptr) {
        const F sine_2 = chord * (1.0f - 0.25f * chord);
        const F cosine_2 = 1.0f - sine_2 * disc.per_sine_2;
        darkened = 1.0f - sqrt_lanes(cosine_2 > 0.0f ? cosine_2 : F{});
      }
      for (int b = 0; b < light.bands; ++b) {
        float* const at = out + b * L::count + l;
        const float limb = disc.limb != nullptr ? disc.limb[b] : 0.0f;
        store(at, load<F>(at) + keep(inside, disc.radiance[b] * (1.0f - limb * darkened)));
      }
    }
  }
}

// Directions of some lanes towards light from afar, of random numbers in [0, 1); as
// sample_far_direction.
template <typename L>
OMMA_HD void sample_far_lanes(const LightView& light, const float* u0, const float* u1,
                              unsigned lanes, float (&direction)[3][L::count]) {
  using F = typename L::F;
  using I = typename L::I;
  for (int l = 0; l < L::count; l += L::width) {
    const auto wanted = lanes_on<L>(lanes, l);
    if (!any_lane(wanted)) continue;
    I open = keep(wanted, lane_numbers<L>() * 0 + 1);
    F left = load<F>(u0 + l), d[3] = {F{}, broadcast<F>(1.0f), F{}};
    for (int i = 0; i < light.disc_count; ++i) {
      const DiscView& disc = light.discs[i];
      if (!(disc.probability > 0.0f)) continue;
      const auto here = open != 0 && left < disc.probability;
      F in_disc[3];
      sample_disc(disc, left / disc.probability, load<F>(u1 + l), in_disc);
      for (int r = 0; r < 3; ++r) d[r] = here ? in_disc[r] : d[r];
      open = here ? open * 0 : open;
      left -= disc.probability;
    }
    for (int r = 0; r < 3; ++r) store(direction[r] + l, d[r]);
    if (!(light.sky.probability > 0.0f) || !any_lane(open != 0)) continue;
    alignas(64) float of_sky[L::width];
    store(of_sky, left / light.sky.probability);
    for (unsigned bits = lane_bits(open != 0); bits != 0; bits &= bits - 1) {
      const int k = lowest_bit(bits);
      const Vec3 there = sample_sky(light.sky, fminf(of_sky[k], 0x1.fffffep-1f), u1[l + k]);
      direction[0][l + k] = there.x, direction[1][l + k] = there.y, direction[2][l + k] = there.z;
    }
  }
}

// The probability with which a light sample has the direction of each of some lanes, whose places are
// given; as escaped_light_pdf. The other lanes' are left.
template <typename L>
OMMA_HD void find_far_pdf(const LightView& light, const float (&direction)[3][L::count],
                          const SkyPlace (&places)[L::count], unsigned lanes, float* pdf) {
  using F = typename L::F;
  for (int l = 0; l < L::count; l += L::width) {
    const auto wanted = lanes_on<L>(lanes, l);
    if (!any_lane(wanted)) continue;
    F d[3], of_discs{};
    load_3(direction, l, d);
    for (int i = 0; i < light.disc_count; ++i) {
      const DiscView& disc = light.discs[i];
      of_discs += keep(chord_2_lanes(d, disc.direction) <= disc.chord_2,
                       broadcast<F>(disc.probability * disc.density));
    }
    alignas(64) float of_sky[L::width] = {};
    if (light.sky.probability > 0.0f)
      for (unsigned bits = lanes >> l & ((1u << L::width) - 1u); bits != 0; bits &= bits - 1) {
        const int k = lowest_bit(bits);
        of_sky[k] = light.sky.cell_density[cell_of(light.sky, places[l + k])];
      }
    const F found =
        light.far_probability * (light.sky.probability * load<F>(of_sky) + of_discs);
    store(pdf + l, wanted ? found : load<F>(pdf + l));
  }
}

}  // namespace omma
