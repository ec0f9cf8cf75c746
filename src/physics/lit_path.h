// Paths of light, from the eye backwards: at each surface one light is asked directly (next-event
// estimation), and the path goes on in one direction of one of the surface's lobes. What both could
// have found is weighed by the balance heuristic (Veach 1997, chapter 9), for each lobe by itself.
// Paths end by Russian roulette. Unbiased; the reference for all faster ways.
#pragma once

#include "physics/ask_lights.h"
#include "physics/truth.h"

namespace omma {

// Whether surfaces let light straight through: then rays remember which they have passed.
OMMA_HD bool lets_through(const SceneView& scene) {
  return scene.has_blend || scene.has_glass;
}

// Whether the flight after the last scattering that the depth allows can only find light from afar.
OMMA_HD bool ends_in_the_dark(const SceneView& scene) {
  return scene.depth > 0 && !lets_through(scene) && scene.light->emissive_count == 0;
}

// Paths that gloss did not lose: those past what lets light by, and those that were scattered, whose
// rays leave the surface. Returns the lanes that go on.
template <typename L>
OMMA_HD unsigned go_on(const SceneView& scene, Packet<L>& packet, PathState<L>& state, unsigned on,
                       const HitGeometry<L>& geometry, const Onward<L>& onward, const float* most,
                       PassedSurfaces<L::count>* passed, const PathMemory& memory) {
  using F = typename L::F;
  using I = typename L::I;
  constexpr int n = L::count;
  constexpr auto straight = static_cast<std::int32_t>(Lobe::straight);
  on &= bits_where<L>([&](int l) {
    const I lobe = load<I>(onward.lobe + l);
    return lobe == let_by || (lobe != no_lobe && load<F>(most + l) > 0.0f &&
                              load<F>(onward.density + l) > 0.0f);
  });
  unsigned by = 0;
  if (passed != nullptr)
    by = on & bits_where<L>([&](int l) {
      const I lobe = load<I>(onward.lobe + l);
      return lobe == let_by || lobe == straight;
    });
  unsigned scattered = on & ~by;
  // Many paths that are baked add up, so they may end early.
  const int roulette_from = state.gathers || scene.baked != nullptr ? 0 : roulette_after;
  for (int l = 0; l < n; l += L::width) {
    const I scatterings = load<I>(state.scatterings + l);
    const auto asked = scatterings >= roulette_from && lanes_on<L>(scattered, l);
    if (!any_lane(asked)) continue;
    const F largest = load<F>(most + l), bound = broadcast<F>(most_survival);
    const F survival = scene.baked != nullptr ? gloss_survival(largest, scatterings)
                                              : (largest < bound ? largest : bound);
    const auto ends = asked && load<F>(onward.roulette + l) >= survival;
    scattered &= ~(lane_bits(ends) << l);
    const F one = broadcast<F>(1.0f), scale = asked ? one / survival : one;
    for (int b = 0; b < scene.bands; ++b) {
      float* const at = memory.throughput + b * n + l;
      store(at, load<F>(at) * scale);
    }
  }
  for (int l = 0; l < n; l += L::width) {
    const auto is = lanes_on<L>(scattered, l);
    if (!any_lane(is)) continue;
    const I scatterings = load<I>(state.scatterings + l);
    store(state.scatterings + l, is ? scatterings + 1 : scatterings);
    store(state.density + l, is ? load<F>(onward.density + l) : load<F>(state.density + l));
    store(packet.footprint_rad + l, is ? F{} : load<F>(packet.footprint_rad + l));
  }
  for (int l = 0; l < n; ++l) {
    if ((by >> l & 1u) != 0) pass(*passed, l, packet.rays);
    if ((scattered >> l & 1u) == 0) continue;
    packet.rays.mask[l] = packet.light_sees;
    if (passed != nullptr) passed->count[l] = 0;
  }
  leave_surfaces<L>(geometry, onward.direction, scattered, packet.rays);
  for (int l = 0; l < n; l += L::width)
    store(state.flight + l, load<I>(state.flight + l) + 1);
  return by | scattered;
}

// One flight of the paths of those lanes of a packet that are in `on`: adds what they find to
// `radiance` [component][band][lane], and returns the lanes whose paths go on; rays, state and
// throughput are those of the next flight then. `passed`: where surfaces let light through, else
// null. `first`: takes what the rays met, or null.
template <typename L, typename Search>
OMMA_HD_CALLED unsigned fly(const SceneView& scene, Search& search, Spread spread, unsigned on,
                     Packet<L>& packet, PathState<L>& state, PassedSurfaces<L::count>* passed,
                     const PathMemory& memory, float* radiance, FirstHits<L>* first = nullptr) {
  using I = typename L::I;
  constexpr int n = L::count;
  alignas(n * 4) std::int32_t active[n];
  const auto lane_is_on = [&](unsigned lanes) {
    const I off = lane_numbers<L>() * 0;
    for (int l = 0; l < n; l += L::width) store(active + l, lanes_on<L>(lanes, l) ? off - 1 : off);
  };
  lane_is_on(on);
  const auto scattered_most = [&](int l) { return load<I>(state.scatterings + l) >= scene.depth; };
  clear_hits<L>(packet.rays);
  FarPlaces<L> far;
  if (ends_in_the_dark(scene) && (on & ~bits_where<L>(scattered_most)) == 0) {
    find_far_places<L>(scene, packet, state, on, far);
    const unsigned seen = on & ~search.occluded(active, packet.rays);
    if (seen != 0) add_far<L>(scene, packet, state, seen, far, memory, radiance);
    return 0;
  }

  // What the rays meet, and where they meet nothing the sky; that is read after the surfaces, when
  // what was asked for of it has come.
  Hits<L> hits;
  search.closest(active, packet.rays, passed, spread);
  find_hits<L>(search.placed(), packet, hits);
  if (first != nullptr) *first = {packet, hits};
  const unsigned met = on & bits_where<L>([&](int l) { return load<I>(hits.mesh + l) >= 0; });
  const unsigned missed = on & ~met;
  if (missed != 0) find_far_places<L>(scene, packet, state, missed, far);
  for (int l = 0; l < n; l += L::width) {
    const I mesh = load<I>(hits.mesh + l);
    store(hits.mesh + l, lanes_on<L>(met, l) ? mesh : mesh * 0 - 1);
  }

  BakedPlaces<n> baked = {};
  HitGeometry<L> geometry;
  LitSurface<L> surface;
  if (met != 0) {
    if (scene.baked != nullptr) find_baked<L>(scene, packet, hits, baked);
    eval_geometry<L>(scene, packet.rays, hits, geometry);
    eval_lit_surfaces<L>(scene, packet, hits, geometry, memory, surface);
  }
  if (missed != 0) add_far<L>(scene, packet, state, missed, far, memory, radiance);
  if (met == 0) return 0;
  if (scene.shines)
    add_emission<L>(scene, packet, hits, surface, state, met, memory, radiance);

  // Light that a surface lets by; and the end of paths that have been scattered often enough.
  unsigned by = 0;
  if (scene.has_blend)
    for (int l = 0; l < n; ++l) {
      if ((met >> l & 1u) == 0 || !(surface.alpha[l] < 1.0f)) continue;
      const std::uint32_t seed = uint_of(packet.hash[l]) + uint_of(packet.sample[l]) * 0x9e3779b9u +
                                 uint_of(state.flight[l]) * 0x85ebca6bu;
      if (open_unit(mix_bits_32(seed)) >= surface.alpha[l]) by |= 1u << l;
    }
  on = met;
  if (scene.depth > 0) on &= by | ~bits_where<L>(scattered_most);
  const unsigned scattering = on & ~by;
  if (scene.baked != nullptr)
    eval_baked<L>(scene, packet, baked, geometry, surface, scattering, memory);

  // A light for each, and what surfaces make of it.
  ScatteringPacket<L> points;
  make_scattering<L>(scene, packet, surface, memory, points);
  AskedLights<L> lights;
  Scattered<L> direct;
  sample_lights<L>(scene, packet, state, geometry, scattering, lights);
  scatter_sample<L>(points, lights.direction, lights.density, lights.is_delta, direct);
  ask_lights<L>(scene, search, packet, state, geometry, lights, direct, scattering, memory,
                radiance);

  if (scene.baked != nullptr)
    add_baked<L>(scene, state, points, scattering, memory, radiance);
  if (memory.cell_errors != nullptr)
    add_cell_errors<L>(scene, packet, state, points, baked, scattering, memory);

  // On: past what was let by, or as scattered.
  Onward<L> onward;
  send_on<L>(packet, state, points, scattering, onward);
  for (unsigned bits = by; bits != 0; bits &= bits - 1) onward.lobe[lowest_bit(bits)] = let_by;
  alignas(n * 4) float most[n];
  lengthen<L>(scene, packet, onward, state, memory, most);
  return go_on<L>(scene, packet, state, on, geometry, onward, most, passed, memory);
}

// Radiance [component][band][lane] of the rays of a packet, where `valid` [lane] is not 0, to the
// end of their paths. Rays that gather begin at surfaces; see PathState.
template <typename L, typename Search>
OMMA_HD void eval_lit_path(const SceneView& scene, Search& search, const std::int32_t* valid,
                           Packet<L>& packet, const PathMemory& memory, float* radiance,
                           bool gathers = false, FirstHits<L>* first = nullptr) {
  const int components = scene.polarized ? 3 : 1;
  for (int i = 0; i < components * scene.bands * L::count; ++i) radiance[i] = 0;
  PathState<L> state;
  state.gathers = gathers;
  begin_paths<L>(scene, state, memory);
  PassedSurfaces<L::count> passed;
  unsigned on = packet_bits<L>(valid);
  for (int flight = 0; on != 0 && flight < most_flights; ++flight) {
    const Spread spread = flight == 0 && !gathers ? Spread::together : Spread::scattered;
    on = fly<L>(scene, search, spread, on, packet, state, lets_through(scene) ? &passed : nullptr,
                memory, radiance, flight == 0 ? first : nullptr);
  }
}

}  // namespace omma
