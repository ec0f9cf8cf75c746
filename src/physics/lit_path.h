// Paths of light, from the eye backwards: at each surface one light is asked directly (next-event
// estimation), and the path goes on in one direction of one of the surface's lobes. What both could
// have found is weighed by the balance heuristic (Veach 1997, chapter 9), for each lobe by itself.
// Paths end by Russian roulette. Unbiased; the reference for all faster ways.
#pragma once

#include "physics/path_scatter.h"
#include "physics/sun_map.h"
#include "physics/truth.h"

namespace omma {

// From so many scatterings on a path may end before it leaves the scene, and it goes on with at
// most this probability.
inline constexpr int roulette_after = 3;
inline constexpr float most_survival = 0.95f;

// A light that lies on a surface is not hidden by that surface: a ray to it looks this far.
inline constexpr float up_to_light = 1.0f - 1e-4f;

// Radiance [component][band][lane] of the rays of a packet, where `valid` [lane] is not 0. Rays that
// gather begin at surfaces; see PathState. `first`: takes what the rays met first, or null.
template <typename L, typename Search>
OMMA_HD void eval_lit_path(const SceneView& scene, Search& search, const std::int32_t* valid,
                           Packet<L>& packet, const PathMemory& memory, float* radiance,
                           bool gathers = false, FirstHits<L>* first = nullptr) {
  using F = typename L::F;
  using I = typename L::I;
  constexpr int n = L::count;
  const int components = scene.polarized ? 3 : 1, stride = scene.bands * n;
  const bool lets_through = scene.has_blend || scene.has_glass;
  // Whether the last flight of a path can only find light from afar.
  const bool is_dark = !lets_through && scene.light->emissive_count == 0;
  const bool samples_lights = scene.light->far_probability > 0.0f ||
                              scene.light->lamp_probability > 0.0f ||
                              scene.light->emissive_probability > 0.0f;
  PathState<L> state;
  state.gathers = gathers;
  // Many paths that are baked add up, so they may end early; what gloss sends on in baked light has
  // been cut already.
  const int in_path = gathers ? 1 : roulette_after + 1;
  const int roulette_from = scene.baked != nullptr ? most_flights : in_path;
  PassedSurfaces<n> passed;
  for (int i = 0; i < components * stride; ++i) radiance[i] = 0;
  for (int i = 0; i < stride; ++i) memory.throughput[i] = 1;
  for (int l = 0; l < n; ++l) {
    state.density[l] = INFINITY;
    state.active[l] = valid[l];
    state.scatterings[l] = 0;
    for (int k = 0; k < 9; ++k) state.mueller[k][l] = k % 4 == 0 ? 1.0f : 0.0f;
  }
  unsigned on = packet_bits<L>(state.active);
  for (; on != 0 && state.flight < most_flights; ++state.flight) {
    // What the rays meet, and where they meet nothing the sky.
    Hits<L> hits;
    clear_hits<L>(packet.rays);
    if (is_dark && scene.depth > 0 && state.flight == scene.depth) {
      const unsigned met = search.occluded(state.active, packet.rays);
      return add_far<L>(scene, packet, state, on & ~met, memory, radiance);
    }
    const Spread spread =
        state.flight == 0 && !gathers ? Spread::together : Spread::scattered;
    search.closest(state.active, packet.rays, lets_through ? &passed : nullptr, spread);
    find_hits<L>(search.placed(), packet, hits);
    if (first != nullptr) *first = {packet, hits};
    first = nullptr;
    unsigned met = 0;
    for (int l = 0; l < n; l += L::width) met |= lane_bits(load<I>(hits.mesh + l) >= 0) << l;
    met &= on;
    if ((on & ~met) != 0) add_far<L>(scene, packet, state, on & ~met, memory, radiance);
    for (int l = 0; l < n; ++l)
      if ((met >> l & 1u) == 0) hits.mesh[l] = -1;
    if (met == 0) return;

    BakedPlaces<n> baked = {};
    if (scene.baked != nullptr) find_baked<L>(scene, packet, hits, baked);
    HitGeometry<L> geometry;
    LitSurface<L> surface;
    eval_geometry<L>(scene, packet.rays, hits, geometry);
    eval_lit_surfaces<L>(scene, packet, hits, geometry, memory, surface);
    add_emission<L>(scene, packet, hits, surface, state, met, memory, radiance);

    // Light that a surface lets by; and the end of paths that have been scattered often enough.
    unsigned by = 0;
    on = met;
    for (int l = 0; l < n; ++l) {
      if ((met >> l & 1u) == 0) continue;
      if (scene.has_blend && surface.alpha[l] < 1.0f &&
          open_unit(mix_bits_32(uint_of(packet.hash[l]) + uint_of(packet.sample[l]) * 0x9e3779b9u +
                                static_cast<std::uint32_t>(state.flight) * 0x85ebca6bu)) >=
              surface.alpha[l])
        by |= 1u << l;
      else if (scene.depth > 0 && state.scatterings[l] >= scene.depth)
        on &= ~(1u << l);
    }
    const unsigned scattering = on & ~by;
    if (scene.baked != nullptr)
      eval_baked<L>(scene, packet, baked, geometry, surface, scattering, memory);

    // A light for each, sampled.
    LightSample lights[n];
    alignas(n * 4) float to_light[3][n], light_density[n], is_delta[n];
    alignas(n * 4) float which[n], place_x[n], place_y[n];
    for (int l = 0; l < n; l += L::width) {
      store(which + l, choose<L>(packet, state, l, Choice::light).x);
      const auto place = choose<L>(packet, state, l, Choice::place_on_light);
      store(place_x + l, place.x);
      store(place_y + l, place.y);
    }
    const LightView& light = *scene.light;
    unsigned from_afar = 0;
    for (int l = 0; l < n && samples_lights; l += L::width)
      from_afar |= lane_bits(load<F>(which + l) < light.far_probability) << l;
    from_afar &= scattering;
    sample_far_lanes<L>(light, place_x, place_y, from_afar, to_light);
    const unsigned near = samples_lights ? scattering & ~from_afar : 0;
    for (int l = 0; l < n; ++l) {
      lights[l] = {};
      light_density[l] = 0;
      if ((from_afar >> l & 1u) != 0) {
        lights[l].kind = LightKind::far;
        continue;
      }
      if ((near >> l & 1u) != 0)
        lights[l] = sample_near_light(scene, vec_at(geometry.position, l),
                                      which[l] - light.far_probability, place_x[l], place_y[l]);
      light_density[l] = lights[l].pdf;
      to_light[0][l] = lights[l].direction.x;
      to_light[1][l] = lights[l].direction.y;
      to_light[2][l] = lights[l].direction.z;
    }
    SkyPlace places[n] = {};
    if (light.sky.probability > 0.0f)
      find_far_lanes<L>(light, to_light, from_afar, components, places);
    find_far_pdf<L>(light, to_light, places, from_afar, light_density);
    for (int l = 0; l < n; ++l) is_delta[l] = lights[l].is_delta ? 1.0f : 0.0f;
    Scattered<L> direct;
    Onward<L> onward;
    scatter_packet<L>(scene, packet, surface, state, memory, scattering, radiance, to_light,
                      light_density, is_delta, direct, onward);

    // Shadow rays to those from which light would come to the eye.
    Packet<L> shadow;
    clear<L>(shadow.rays);
    for (int l = 0; l < n; ++l) shadow.rays.mask[l] = packet.light_sees;
    leave_surfaces<L>(geometry, to_light, ~0u, shadow.rays);
    alignas(n * 4) std::int32_t asked[n];
    alignas(n * 4) float weight[n] = {};
    unsigned open = 0, mapped = 0;
    if (scene.sun_map != nullptr) eval_sun_map<L>(*scene.sun_map, geometry, weight);
    for (int l = 0; l < n; ++l) {
      const bool is_seen = direct.reflected[l] > 0 || direct.transmitted[l] > 0 ||
                           direct.dielectric[0][l] > 0 || direct.metal[l] > 0 ||
                           direct.coat[0][l] > 0;
      asked[l] = (scattering >> l & 1u) != 0 && light_density[l] > 0 && is_seen ? -1 : 0;
      if (scene.sun_map != nullptr && lights[l].kind == LightKind::far) {
        if (asked[l] != 0 && weight[l] > 0) mapped |= 1u << l;
        asked[l] = 0;
      } else {
        weight[l] = 1;
      }
      if (asked[l] != 0) open |= 1u << l;
      shadow.rays.t_far_m[l] = lights[l].distance_m * up_to_light;
      shadow.footprint_rad[l] = 0;
    }
    if (open != 0)
      open = lets_through ? dim_by_passing<L>(scene, search, open, shadow, memory.shadow)
                          : open & ~search.occluded(asked, shadow.rays);
    open |= mapped;
    if (open != 0) {
      alignas(n * 4) float axis[3][n] = {};
      for (int i = 0; i < components * stride; ++i) memory.light[i] = 0;
      for (int l = 0; l < n; ++l) {
        const Vec3 d = vec_at(to_light, l);
        if (scene.polarized) {
          const Vec3 up = vertical_axis(d);
          axis[0][l] = up.x, axis[1][l] = up.y, axis[2][l] = up.z;
        }
        if ((open >> l & 1u) == 0)
          weight[l] = 0;
        else if (lights[l].kind != LightKind::far)
          eval_light_sample(scene, lights[l], components, memory.light + l, n, stride);
        else if (light.sky.probability > 0.0f)
          eval_sky(light, d, places[l], components, memory.light + l, n, stride);
      }
      add_disc_light<L>(light, to_light, open & from_afar, memory.light);
      if (lets_through)
        for (int c = 0; c < components; ++c)
          for (int i = 0; i < stride; ++i)
            memory.light[c * stride + i] *= memory.shadow.throughput[i];
      scatter_light<L>(scene, packet, direct, to_light, axis, memory, memory.light);
      // Scattered, it is by the rays' own axes.
      add_light<L>(scene, packet, state, weight, packet.reference, memory, memory.light, radiance);
    }

    // On: past what was let by, or as scattered.
    alignas(n * 4) float most[n];
    for (int l = 0; l < n; ++l)
      if ((by >> l & 1u) != 0) onward.lobe[l] = let_by;
    lengthen<L>(scene, packet, onward, state, memory, most);
    if (scene.baked != nullptr)
      follow_some<L>(scene, packet, state, on, onward, most, memory, radiance);
    unsigned scattered = 0;
    for (int l = 0; l < n; ++l) {
      const unsigned bit = 1u << l;
      if ((on & bit) == 0) continue;
      if (onward.lobe[l] == let_by) {
        pass(passed, l, packet.rays);
        continue;
      }
      if (onward.lobe[l] == no_lobe || !(most[l] > 0) || !(onward.density[l] > 0)) {
        on &= ~bit;
        continue;
      }
      if (onward.lobe[l] == static_cast<std::int32_t>(Lobe::straight)) {
        pass(passed, l, packet.rays);
        continue;
      }
      ++state.scatterings[l];
      if (roulette_from <= state.scatterings[l]) {
        const float survival = fminf(most[l], most_survival);
        if (onward.roulette[l] >= survival) {
          on &= ~bit;
          continue;
        }
        const float scale = 1.0f / survival;
        for (int b = 0; b < scene.bands; ++b) memory.throughput[b * n + l] *= scale;
      }
      state.density[l] = onward.density[l];
      scattered |= bit;
      packet.rays.mask[l] = packet.light_sees;
      packet.footprint_rad[l] = 0;
      passed.count[l] = 0;
    }
    leave_surfaces<L>(geometry, onward.direction, scattered, packet.rays);
    for (int l = 0; l < n; ++l) state.active[l] = (on >> l & 1u) != 0 ? -1 : 0;
  }
}

}  // namespace omma
