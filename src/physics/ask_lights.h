// Next-event estimation for the lanes of a packet: a light sampled for each surface that was met, a
// ray to it or a look at the sun's map, and what comes to the eye of it.
#pragma once

#include "physics/baked_scatter.h"
#include "physics/sun_map.h"

namespace omma {

// A light that lies on a surface is not hidden by that surface: a ray to it looks this far.
inline constexpr float up_to_light = 1.0f - 1e-4f;

// A sample of light for each lane of a packet, all [lane].
template <typename L>
struct AskedLights {
  static constexpr int n = L::count;
  alignas(n * 4) float direction[3][n];  // unit, towards the light; zeros where there is none
  alignas(n * 4) float density[n];       // per solid angle, choice of light included; 0: none
  alignas(n * 4) float is_delta[n];      // 1 for lamps, which no path meets
  alignas(n * 4) float distance_m[n];
  unsigned from_afar, near;  // lanes with light from the sky and discs, and with other light
  SkyPlaces<typename L::F, typename L::I> places[n / L::width];  // of those from afar
  LightSample other[n];                                          // of those that are near
};

template <typename L>
OMMA_HD void sample_lights(const SceneView& scene, const Packet<L>& packet,
                           const PathState<L>& state, const HitGeometry<L>& geometry,
                           unsigned scattering, AskedLights<L>& asked) {
  using F = typename L::F;
  constexpr int n = L::count;
  const LightView& light = *scene.light;
  for (int l = 0; l < n; l += L::width) {
    for (int r = 0; r < 3; ++r) store(asked.direction[r] + l, F{});
    store(asked.density + l, F{});
    store(asked.is_delta + l, F{});
    store(asked.distance_m + l, broadcast<F>(INFINITY));
  }
  asked.from_afar = asked.near = 0;
  const bool has_near = light.lamp_probability > 0.0f || light.emissive_probability > 0.0f;
  if (!has_near && !(light.far_probability > 0.0f)) return;

  alignas(n * 4) float which[n] = {}, place_x[n], place_y[n];
  for (int l = 0; l < n; l += L::width) {
    if (has_near) store(which + l, choose<L>(packet, state, l, Choice::light).x);
    const auto place = choose<L>(packet, state, l, Choice::place_on_light);
    store(place_x + l, place.x);
    store(place_y + l, place.y);
  }
  asked.from_afar = scattering;
  if (has_near)
    asked.from_afar &= bits_where<L>([&](int l) {
      return load<F>(which + l) < light.far_probability;
    });
  asked.near = scattering & ~asked.from_afar;
  sample_far_lanes<L>(light, place_x, place_y, asked.from_afar, asked.direction);
  if (light.sky.probability > 0.0f)
    find_far_lanes<L>(light, asked.direction, asked.from_afar, asked.places);
  find_far_pdf<L>(light, asked.direction, asked.places, asked.from_afar, asked.density);
  if (light.sky.probability > 0.0f)
    choose_nodes<L>(packet, state, Choice::place_on_light, asked.places);
  for (unsigned bits = asked.near; bits != 0; bits &= bits - 1) {
    const int l = lowest_bit(bits);
    const LightSample sample =
        sample_near_light(scene, vec_at(geometry.position, l), which[l] - light.far_probability,
                          place_x[l], place_y[l]);
    asked.other[l] = sample;
    asked.direction[0][l] = sample.direction.x;
    asked.direction[1][l] = sample.direction.y;
    asked.direction[2][l] = sample.direction.z;
    asked.density[l] = sample.pdf;
    asked.is_delta[l] = sample.is_delta ? 1.0f : 0.0f;
    asked.distance_m[l] = sample.distance_m;
  }
}

// Of some lanes those whose light is not hidden; what surfaces that let light through leave of it is
// in memory.shadow.throughput then.
template <typename L, typename Search>
OMMA_HD unsigned reach_lights(const SceneView& scene, Search& search, const Packet<L>& packet,
                              const HitGeometry<L>& geometry, const AskedLights<L>& lights,
                              unsigned lanes, const PathMemory& memory) {
  using F = typename L::F;
  using I = typename L::I;
  constexpr int n = L::count;
  if (lanes == 0) return 0;
  Packet<L> shadow;
  clear<L>(shadow.rays);
  alignas(n * 4) std::int32_t asked[n];
  leave_surfaces<L>(geometry, lights.direction, ~0u, shadow.rays);
  for (int l = 0; l < n; ++l) {
    shadow.rays.mask[l] = packet.light_sees;
    shadow.footprint_rad[l] = 0;
  }
  for (int l = 0; l < n; l += L::width) {
    const I off = lane_numbers<L>() * 0;
    store(asked + l, lanes_on<L>(lanes, l) ? off - 1 : off);
    store(shadow.rays.t_far_m + l, load<F>(lights.distance_m + l) * up_to_light);
  }
  if (scene.has_blend || scene.has_glass)
    return dim_by_passing<L>(scene, search, lanes, shadow, memory.shadow);
  return lanes & ~search.occluded(asked, shadow.rays);
}

// Adds what the surfaces of some lanes send to the eye of the light that was sampled for them.
template <typename L, typename Search>
OMMA_HD void ask_lights(const SceneView& scene, Search& search, const Packet<L>& packet,
                        const PathState<L>& state, const HitGeometry<L>& geometry,
                        const AskedLights<L>& lights, const Scattered<L>& direct,
                        unsigned scattering, const PathMemory& memory, float* radiance) {
  using F = typename L::F;
  constexpr int n = L::count;
  const LightView& light = *scene.light;
  const bool dims = scene.has_blend || scene.has_glass;
  const int components = scene.polarized ? 3 : 1, stride = scene.bands * n;
  const unsigned asked = scattering & bits_where<L>([&](int l) {
    const F scattered = load<F>(direct.reflected + l) + load<F>(direct.transmitted + l) +
                        load<F>(direct.dielectric[0] + l) + load<F>(direct.metal + l) +
                        load<F>(direct.coat[0] + l);
    return load<F>(lights.density + l) > 0.0f && scattered > 0.0f;
  });
  if (asked == 0) return;
  const bool has_sky = light.sky.probability > 0.0f;
  const unsigned from_sky = has_sky ? asked & lights.from_afar : 0;
  if (from_sky != 0)
    fetch_sky_nodes<L>(light.sky, from_sky, scene.polarized ? from_sky : 0, lights.places);

  // How much of it is seen.
  alignas(n * 4) float weight[n];
  const unsigned mapped = scene.sun_map != nullptr ? asked & lights.from_afar : 0;
  const unsigned open =
      reach_lights<L>(scene, search, packet, geometry, lights, asked & ~mapped, memory);
  for (int l = 0; l < n; l += L::width)
    store(weight + l, keep(lanes_on<L>(open, l), broadcast<F>(1.0f)));
  if (mapped != 0) {
    alignas(n * 4) float seen[n];
    eval_sun_map<L>(*scene.sun_map, geometry, seen);
    for (int l = 0; l < n; l += L::width)
      store(weight + l, lanes_on<L>(mapped, l) ? load<F>(seen + l) : load<F>(weight + l));
  }
  const unsigned seen = bits_where<L>([&](int l) { return load<F>(weight + l) > 0.0f; });
  if (seen == 0) return;

  alignas(n * 4) float axis[3][n] = {};
  if (scene.polarized) vertical_axes<L>(lights.direction, axis);
  const unsigned far_seen = seen & lights.from_afar;
  eval_sky_lanes<L>(light, lights.direction, lights.places, has_sky ? far_seen : 0, components,
                    far_seen, true, memory.light);
  for (unsigned bits = seen & lights.near; bits != 0; bits &= bits - 1) {
    const int l = lowest_bit(bits);
    eval_light_sample(scene, lights.other[l], components, memory.light + l, n, stride);
  }
  add_disc_light<L>(light, lights.direction, far_seen, nullptr, memory.light);
  if (dims)
    for (int c = 0; c < components; ++c)
      for (int i = 0; i < stride; ++i)
        memory.light[c * stride + i] *= memory.shadow.throughput[i];
  scatter_light<L>(scene, packet, direct, lights.direction, axis, memory, memory.light);
  // Scattered, it is by the rays' own axes.
  add_light<L>(scene, packet, state, weight, packet.reference, memory, memory.light, radiance);
}

}  // namespace omma
