// Light from afar for the lanes of a packet: discs such as the sun, and directions in them, all
// lanes at once; the sky, whose maps are read by rows.
#pragma once

#include "physics/lanes/lane_mask.h"
#include "physics/lanes/rows.h"
#include "physics/lanes/vector3.h"
#include "physics/light/cloud_shadow.h"
#include "physics/light/sky.h"

namespace omma {

template <typename F>
OMMA_HD F chord_2(const Vector3<F>& d, Vec3 centre) {
  const Vector3<F> across = d - vector_of(centre);
  return dot(across, across);
}

// Of a packet's directions.
template <typename L>
using SkyLookups = SkyLookup<typename L::F, typename L::I>[L::count / L::width];

// Where light from afar of a packet's directions is to be looked up.
template <typename L>
OMMA_HD void find_far(const LightView& light, const float (&direction)[3][L::count],
                            LaneMask<L> lanes, SkyLookups<L>& places) {
  using F = typename L::F;
  for (int l = 0; l < L::count; l += L::width) {
    if (light.sky.rows == 0 || !any_lane(lanes.at(l))) {
      places[l / L::width] = {};
      continue;
    }
    const auto d = keep(lanes.at(l), load_vector<F>(direction, l));
    places[l / L::width] = find_on_sky(light.sky, d.x, d.y, d.z);
  }
}

// Of the nodes about the places of lanes that go at once: the lower two, in the order of
// SkyView::radiance, and how much all four count, [lane].
template <typename L>
struct SkyCorners {
  static constexpr int n = L::width;
  alignas(n * 4) std::int32_t left[n], right[n];
  alignas(n * 4) float low_left[n], low_right[n], high_left[n], high_right[n];
};

template <typename L>
OMMA_HD void find_corners(const SkyView& sky, const SkyLookup<typename L::F, typename L::I>& place,
                          SkyCorners<L>& corners) {
  using F = typename L::F;
  const auto first = (place.half * sky.rows + place.row) * sky.columns;
  const F right = place.along_column, up = place.along_row;
  const F high = up * sky.per_unit, low = (1.0f - up) * sky.per_unit;
  store(corners.left, first + place.column);
  store(corners.right, first + place.next);
  store(corners.low_left, (1.0f - right) * low);
  store(corners.low_right, right * low);
  store(corners.high_left, (1.0f - right) * high);
  store(corners.high_right, right * high);
}

// Stochastic bilinear interpolation: one of the four nodes about each direction, by its weight,
// which in the mean is what lies between them. Rays that were scattered go to many places of the
// map, whose nodes are far apart in memory. `bits`: random.
template <typename F, typename I, typename U>
OMMA_HD void choose_node(SkyLookup<F, I>& place, U bits) {
  const F one = broadcast<F>(1.0f);
  const F u = (to_float(int_of(bits & 0xffffu)) + 0.5f) * 0x1p-16f;
  const F v = (to_float(int_of(bits >> 16)) + 0.5f) * 0x1p-16f;
  place.along_column = keep(u < place.along_column, one);
  place.along_row = keep(v < place.along_row, one);
}

// Calls `eval(k, node)` for those of some lanes that go at once, with the node that was chosen.
template <typename L, typename Eval>
OMMA_HD void for_each_node(const SkyView& sky, const SkyLookup<typename L::F, typename L::I>& place,
                           unsigned lanes, const Eval& eval) {
  const auto column = place.along_column > 0.0f ? place.next : place.column;
  const auto row = place.half * sky.rows + place.row + to_int(place.along_row);
  alignas(L::width * 4) std::int32_t node[L::width];
  store(node, row * sky.columns + column);
  for (; lanes != 0; lanes &= lanes - 1) eval(lowest_bit(lanes), node[lowest_bit(lanes)]);
}

// Asks for what eval_nodes will read, of lanes in `keeps` also Q and U: maps are larger than what a
// processor holds near it.
template <typename L>
OMMA_HD void fetch_sky_nodes(const SkyView& sky, LaneMask<L> lanes, LaneMask<L> keeps,
                             const SkyLookups<L>& places) {
  if (sky.rows == 0) return;
  const auto fetch = [](const float* row, int size) {
    for (int i = 0; i < size; i += 16) fetch_line(row + i);
  };
  for (int l = 0; l < L::count; l += L::width)
    for_each_node<L>(sky, places[l / L::width], lanes.word(l), [&](int k, std::ptrdiff_t node) {
      fetch(sky.radiance + node * sky.channels, sky.channels);
      if (keeps.has(l + k) && sky.polarisation != nullptr)
        fetch(sky.polarisation + node * 2 * sky.channels, 2 * sky.channels);
    });
}

// eval_sky_lanes at the nodes that were chosen, of lanes that go at once. The axes of a node are
// taken for the direction's, which on average are half a column away to either side.
template <typename L>
OMMA_HD void eval_nodes(const SkyView& sky, const SkyLookup<typename L::F, typename L::I>& place,
                        unsigned lanes, unsigned keeps, const StokesOut& to) {
  std::ptrdiff_t node_of[L::width] = {};
  for_each_node<L>(sky, place, lanes, [&](int k, std::ptrdiff_t node) { node_of[k] = node; });
  const auto read_nodes = [&](const float* table, int size, unsigned wanted, float* out) {
    store_rows<L>(
        sky.channels, wanted,
        [&](int k, const auto& read) { return sky.per_unit * read(table + node_of[k] * size); },
        out);
  };
  read_nodes(sky.radiance, sky.channels, lanes, to.stokes);
  for (int p = 1; p < to.components; ++p)
    read_nodes(sky.polarisation + (p - 1) * sky.channels, 2 * sky.channels, keeps,
               to.stokes + p * to.component_stride);
}

// Which directions of a packet's are looked up in the sky, and how.
template <typename L>
struct SkyQuery {
  const float (&direction)[3][L::count];
  const SkyLookups<L>& places;
  LaneMask<L> lanes;
  LaneMask<L> keeps;  // of them those that need Q and U; they are zeros in the others
  bool at_nodes;      // of the nodes that were chosen, else between nodes
};

// Radiance of the sky [component][band][lane], zeros in lanes that do not ask.
template <typename L>
OMMA_HD void eval_sky_lanes(const LightView& light, const SkyQuery<L>& query, int components,
                            float* out) {
  constexpr int n = L::count, width = L::width;
  const SkyView& sky = light.sky;
  const int stride = light.bands * n;
  const LaneMask<L> lanes = sky.rows == 0 ? LaneMask<L>{} : query.lanes;
  const LaneMask<L> keeps = sky.polarisation == nullptr ? LaneMask<L>{} : query.keeps;
  const bool by_one = sky.band_from_channel != nullptr || (keeps.any() && sky.turns_axes);
  const int left_dark = !lanes.any() || by_one ? 0 : (keeps.any() ? 3 : 1);
  for (int i = left_dark * stride; i < components * stride; ++i) out[i] = 0;
  for (int l = 0; lanes.any() && l < n; l += width) {
    const auto& place = query.places[l / width];
    const unsigned here = lanes.word(l), kept = here & keeps.word(l);
    if (query.at_nodes && !by_one) {
      eval_nodes<L>(sky, place, here, kept, {out + l, keeps.any() ? 3 : 1, n, stride});
      continue;
    }
    SkyCorners<L> at;
    find_corners<L>(sky, place, at);
    if (by_one) {
      for (unsigned bits = here; bits != 0; bits &= bits - 1) {
        const int k = lowest_bit(bits);
        const Vec3 d = vec_at(query.direction, l + k);
        eval_sky(light, d, find_on_sky(sky, d.x, d.y, d.z),
                 {out + l + k, (kept >> k & 1u) != 0 ? 3 : 1, n, stride});
      }
      continue;
    }
    const auto mix = [&](const float* table, std::ptrdiff_t node, unsigned wanted, float* to) {
      const std::ptrdiff_t up = node * sky.columns;
      store_rows<L>(
          sky.channels, wanted,
          [&](int k, const auto& read) {
            const float* left = table + node * at.left[k];
            const float* right = table + node * at.right[k];
            return at.low_left[k] * read(left) + at.low_right[k] * read(right) +
                   at.high_left[k] * read(left + up) + at.high_right[k] * read(right + up);
          },
          to + l);
    };
    mix(sky.radiance, sky.channels, here, out);
    for (int p = 0; keeps.any() && p < 2; ++p)
      mix(sky.polarisation + p * sky.channels, 2 * sky.channels, kept, out + (1 + p) * stride);
  }
}

// Directions of light from afar, and where it arrives, m in the traced frame.
template <typename L>
struct FarRays {
  const float (&direction)[3][L::count];
  const float (&place)[3][L::count];
};

// Adds the radiance of discs along the rays of some lanes to `out` [band][lane]. `acceptance_sr` [lane], where not null: of rays from the eye, which count some discs only
// (counts_by_rays); 0 for others.
template <typename L>
OMMA_HD void add_disc_light(const LightView& light, const FarRays<L>& rays, LaneMask<L> lanes,
                            const float* acceptance_sr, float* out) {
  using F = typename L::F;
  for (int i = 0; i < light.disc_count; ++i) {
    const DiscView& disc = light.discs[i];
    for (int l = 0; l < L::count; l += L::width) {
      const F chord = chord_2(load_vector<F>(rays.direction, l), disc.direction);
      auto inside = lanes.at(l) && chord <= disc.chord_2;
      if (!any_lane(inside)) continue;
      if (acceptance_sr != nullptr)
        inside =
            inside && !(load<F>(acceptance_sr + l) * (most_over_acceptance * disc.density) >= 1.0f);
      F darkened{};
      if (disc.limb != nullptr) {
        const F sine_2 = chord * (1.0f - 0.25f * chord);
        const F cosine_2 = 1.0f - sine_2 * disc.per_sine_2;
        darkened = 1.0f - sqrt_lanes(cosine_2 > 0.0f ? cosine_2 : F{});
      }
      F shade = broadcast<F>(1.0f);
      if (light.clouds.optical_depth != nullptr)
        shade = eval_cloud_shadow(light, disc, keep(inside, load_vector<F>(rays.place, l)));
      for (int b = 0; b < light.bands; ++b) {
        float* const at = out + b * L::count + l;
        const float limb = disc.limb != nullptr ? disc.limb[b] : 0.0f;
        const F radiance = disc.radiance[b] * (1.0f - limb * darkened);
        store(at, load<F>(at) + keep(inside, radiance * shade));
      }
    }
  }
}

// Directions of some lanes towards light from afar, of random numbers in [0, 1); as
// sample_far_direction.
template <typename L>
OMMA_HD void sample_far(const LightView& light, const float* u0, const float* u1,
                              LaneMask<L> lanes, float (&direction)[3][L::count]) {
  using F = typename L::F;
  using I = typename L::I;
  for (int l = 0; l < L::count; l += L::width) {
    const auto wanted = lanes.at(l);
    if (!any_lane(wanted)) continue;
    I open = keep(wanted, lane_numbers<L>() * 0 + 1);
    F left = load<F>(u0 + l);
    Vector3<F> d = {F{}, broadcast<F>(1.0f), F{}};
    for (int i = 0; i < light.disc_count; ++i) {
      const DiscView& disc = light.discs[i];
      if (!(disc.probability > 0.0f)) continue;
      const auto here = open != 0 && left < disc.probability;
      d = select(here, sample_disc(disc, left / disc.probability, load<F>(u1 + l)), d);
      open = here ? open * 0 : open;
      left -= disc.probability;
    }
    const auto from_sky = open != 0;
    if (light.sky.probability > 0.0f && any_lane(from_sky)) {
      const F most = broadcast<F>(0x1.fffffep-1f), u = left / light.sky.probability;
      d = select(from_sky,
                 sample_sky(light.sky, keep(from_sky, u < most ? u : most),
                            keep(from_sky, load<F>(u1 + l))),
                 d);
    }
    store_vector(direction, l, d);
  }
}

// The density, per solid angle, with which sample_far gives the direction of each of some lanes,
// whose places on the sky are given. The other lanes' are left.
template <typename L>
OMMA_HD void find_far_pdf(const LightView& light, const float (&direction)[3][L::count],
                          const SkyLookups<L>& places, LaneMask<L> lanes, float* pdf) {
  using F = typename L::F;
  const SkyView& sky = light.sky;
  for (int l = 0; l < L::count; l += L::width) {
    const auto wanted = lanes.at(l);
    if (!any_lane(wanted)) continue;
    const auto d = load_vector<F>(direction, l);
    F density{};
    for (int i = 0; i < light.disc_count; ++i) {
      const DiscView& disc = light.discs[i];
      density += keep(chord_2(d, disc.direction) <= disc.chord_2,
                      broadcast<F>(disc.probability * disc.density));
    }
    if (sky.probability > 0.0f) {
      const auto& place = places[l / L::width];
      const auto row = place.half * (sky.rows - 1) + place.row;
      density =
          sky.probability * gather(sky.cell_density, row * sky.columns + place.column) + density;
    }
    store(pdf + l, wanted ? density : load<F>(pdf + l));
  }
}

}  // namespace omma
