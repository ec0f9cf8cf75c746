// The lit path: a path tracer from the eye backwards, the lanes of a packet side by side. At each
// surface one light is sampled directly (next-event estimation), and the path goes on in one
// direction of one of the surface's lobes; what both could have found is weighed by multiple
// importance sampling (Veach 1997, 9.2), for each lobe by itself. Paths end by Russian roulette.
// Unbiased; the reference for all faster ways.
//
// Read trace_flight first, which is one step of all paths of a packet.
#pragma once

#include "physics/path/air.h"
#include "physics/path/direct_light.h"
#include "physics/path/last_flight.h"
#include "physics/path/lit_splats.h"
#include "physics/rays/hits.h"
#include "physics/rays/search_rays.h"

namespace omma {

// Of some lanes' surfaces those that let the path by, by chance, as they cover a fraction alpha of
// what lies behind: what lies there is found with the probability 1 - alpha with which it counts.
template <typename L>
OMMA_HD LaneMask<L> choose_let_by(const Packet<L>& packet, const PathState<L>& state,
                                  const LitSurface<L>& surface, LaneMask<L> met) {
  LaneMask<L> by;
  met.for_each([&](int l) {
    if (!(surface.alpha[l] < 1.0f)) return;
    const std::uint32_t seed = uint_of(packet.hash[l]) + uint_of(packet.sample[l]) * 0x9e3779b9u +
                               uint_of(state.flight[l]) * 0x85ebca6bu;
    if (open_unit(mix_bits_32(seed)) >= surface.alpha[l]) by.add(l);
  });
  return by;
}

// Russian roulette (Arvo and Kirk 1990, Particle transport and image synthesis): of some lanes'
// paths those that go on, with the probability q of their largest throughput `most` [lane]; their
// throughput grows by 1 / q, so that the mean stays.
template <typename L, typename Search>
OMMA_HD LaneMask<L> play_roulette(const Flight<L, Search>& flight, LaneMask<L> on,
                                  const ScatteringSample<L>& sample, const float* most) {
  using F = typename L::F;
  using I = typename L::I;
  const SceneView& scene = flight.scene;
  // Many paths that are baked add up, so they may end early.
  const int from = flight.state.gathers || scene.baked != nullptr ? 0 : roulette_after;
  for (int l = 0; l < L::count; l += L::width) {
    const I scatterings = load<I>(flight.state.scatterings + l);
    const auto plays = scatterings >= from && on.at(l);
    if (!any_lane(plays)) continue;
    const F largest = load<F>(most + l), bound = broadcast<F>(most_survival);
    const F survival = scene.baked != nullptr ? gloss_survival(largest, scatterings)
                                              : (largest < bound ? largest : bound);
    const auto ends = plays && load<F>(sample.roulette + l) >= survival;
    on.bits &= ~(lane_bits(ends) << l);
    const F one = broadcast<F>(1.0f), scale = plays ? one / survival : one;
    for (int b = 0; b < scene.bands; ++b) {
      float* const at = flight.memory.throughput + b * L::count + l;
      store(at, load<F>(at) * scale);
    }
  }
  return on;
}

// The next rays of paths that were scattered, which leave the surface; `chose`: null where there
// are no near lights.
template <typename L, typename Search>
OMMA_HD void scatter_rays(const Flight<L, Search>& flight, LaneMask<L> scattered,
                          const HitGeometry<L>& geometry, const ScatteringPacket<L>& points,
                          const ScatteringSample<L>& sample) {
  using F = typename L::F;
  using I = typename L::I;
  Packet<L>& packet = flight.packet;
  PathState<L>& state = flight.state;
  for (int l = 0; l < L::count; l += L::width) {
    const auto is = scattered.at(l);
    if (!any_lane(is)) continue;
    const I scatterings = load<I>(state.scatterings + l);
    store(state.scatterings + l, is ? scatterings + 1 : scatterings);
    store(state.density + l, is ? load<F>(sample.density + l) : load<F>(state.density + l));
    const I one = scatterings * 0 + 1, before = load<I>(state.sampled_all + l);
    store(state.sampled_all + l, is ? keep(sample.samples_all.at(l), one) : before);
    store(packet.footprint_rad + l, is ? F{} : load<F>(packet.footprint_rad + l));
  }
  const bool chooses = chooses_lights(flight.scene);
  scattered.for_each([&](int l) {
    if (chooses) {
      state.chose_far[l] = points.far[l];
      state.chose_surface[l] = points.surface[l];
      const Vec3 normal = lit_point(packet, geometry, points.two_sided, l).normal;
      store_vector(state.lit_normal, l, vector_of(normal));
    }
    packet.rays.mask[l] = packet.light_sees;
    state.seen_m[l] = 0;
    if (flight.passed != nullptr) flight.passed->count[l] = 0;
  });
  leave_surfaces<L>(geometry, sample.direction, scattered, packet.rays);
}

// Lanes whose paths go on from what they met: straight past it, as the same ray, or turned aside.
template <typename L>
struct Onward {
  LaneMask<L> straight, turned;

  OMMA_HD LaneMask<L> all() const { return straight | turned; }
};

// Paths of some lanes go on by a sample, or end: by roulette, or where nothing is left of them.
template <typename L, typename Search>
OMMA_HD Onward<L> continue_paths(const Flight<L, Search>& flight, LaneMask<L> on,
                                 const HitGeometry<L>& geometry, const LitSurface<L>& surface,
                                 const ScatteringPacket<L>& points,
                                 const ScatteringSample<L>& sample) {
  using F = typename L::F;
  using I = typename L::I;
  const PathState<L>& state = flight.state;
  alignas(L::count * 4) float most[L::count];
  update_throughput(flight, points, sample, most);
  on &= lanes_where<L>([&](int l) {
    const I lobe = load<I>(sample.lobe + l);
    return load<I>(state.flight + l) < most_flights &&
           (lobe == let_by ||
            (lobe != no_lobe && load<F>(most + l) > 0.0f && load<F>(sample.density + l) > 0.0f));
  });
  LaneMask<L> by, bent;
  if (flight.passed != nullptr) by = on & goes_straight<L>(sample);
  if (flight.scene.has_volumes)
    bent = on & lanes_where<L>([&](int l) { return load<I>(sample.lobe + l) == refracted; });
  const LaneMask<L> scattered = play_roulette(flight, on & ~by & ~bent, sample, most);
  if (flight.scene.has_volumes) leave_media(flight, surface, sample, by, bent, scattered);
  by.for_each([&](int l) { pass(*flight.passed, l, flight.packet.rays); });
  scatter_rays(flight, scattered, geometry, points, sample);
  if (bent.any()) bend_rays(flight, bent, geometry, sample);
  for (int l = 0; l < L::count; l += L::width)
    store(flight.state.flight + l, load<I>(flight.state.flight + l) + 1);
  return {by, bent | scattered};
}

// Where the paths of some lanes go on from the surfaces that they met: past them, of the lanes
// `by`, else in a direction of a lobe.
template <typename L, typename Search>
OMMA_HD_CALLED Onward<L> scatter_paths(const Flight<L, Search>& flight, LaneMask<L> on,
                                       LaneMask<L> by, const HitGeometry<L>& geometry,
                                       const LitSurface<L>& surface,
                                       const ScatteringPacket<L>& points) {
  ScatteringSample<L> sample;
  sample_scattering<L>(flight.packet, flight.state, points, on & ~by, sample);
  by.for_each([&](int l) { sample.lobe[l] = let_by; });
  if (points.bends.any()) refract_rays(flight, points, sample);
  const SceneView& scene = flight.scene;
  if (scene.depth > 0 && scene.has_glass)
    (on & at_full_depth(scene, flight.state) & ~goes_straight<L>(sample)).for_each([&](int l) {
      if (sample.lobe[l] != refracted) sample.lobe[l] = no_lobe;
    });
  const LaneMask<L> straight = on & goes_straight<L>(sample);
  if (scene.has_volumes) count_bent_way(flight, surface, points, straight);
  if (has_air(scene) && flight.passed != nullptr) undo_air(flight, straight);
  return continue_paths(flight, on, geometry, surface, points, sample);
}

// One flight of the paths of some lanes: adds what they find to the radiance, and returns the lanes
// whose paths go on; rays, state and throughput are those of the next flight then. `first`: takes
// what the rays met, or null.
template <typename L, typename Search>
OMMA_HD_CALLED Onward<L> trace_flight(Flight<L, Search> flight, LaneMask<L> on, Spread spread,
                                      FirstHits<L>* first = nullptr) {
  using I = typename L::I;
  const SceneView& scene = flight.scene;
  Packet<L>& packet = flight.packet;
  PathState<L>& state = flight.state;
  const bool is_baked = scene.baked != nullptr;
  clear_hits<L>(packet.rays);

  // The last flight, where only light from afar can be found.
  const LaneMask<L> last = on & on_last_flight(scene, state);
  if (last.any()) trace_last_flight(flight, last);
  on &= ~last;
  if (!on.any()) return {};

  // Intersect.
  Hits<L> hits;
  search_closest(flight.search, on, packet.rays, flight.passed, spread);
  find_hits<L>(flight.search.placed(), packet, hits);
  if (first != nullptr) *first = {packet, hits};
  if (scene.splats != nullptr) pass_splats(flight, on, first);
  const LaneMask<L> met = on & lanes_met(hits), missed = on & ~met;
  for (int l = 0; l < L::count; l += L::width) {
    const I mesh = load<I>(hits.mesh + l);
    store(hits.mesh + l, met.at(l) ? mesh : mesh * 0 - 1);
  }

  // Surfaces, and light from afar where nothing is met: read after them, when what was fetched of
  // the sky has come.
  BakedLookup<L> baked = {};
  HitGeometry<L> geometry;
  LitSurface<L> surface;
  {
    FarLookups<L> far;
    if (missed.any()) look_up_far(flight, missed, far);
    if (met.any()) {
      if (is_baked) find_baked<L>(scene, packet, hits, baked);
      eval_geometry<L>(scene, packet.rays, hits, geometry);
      eval_lit_surfaces<L>(scene, packet, hits, geometry, flight.memory, surface);
    }
    if (missed.any()) add_far(flight, missed, far);
  }
  if (!met.any()) return {};

  // Who is scattered: not those that a surface lets by, nor those at full depth, whose paths end
  // but where light goes straight through.
  const LaneMask<L> by =
      scene.has_blend ? choose_let_by(packet, state, surface, met) : LaneMask<L>{};
  const LaneMask<L> ending = scene.depth > 0 ? at_full_depth(scene, state) : LaneMask<L>{};
  on = scene.has_glass ? met : met & (by | ~ending);
  const LaneMask<L> scattering = met & ~by & ~ending;
  const LaneMask<L> reads = is_baked ? find_read(flight, baked, scattering) : LaneMask<L>{};
  if (reads.any()) eval_baked(flight, baked, geometry, surface, reads);
  ScatteringPacket<L> points;
  make_scattering(flight, surface, reads, points);
  if (scene.has_volumes) pass_media(flight, surface, met);
  if (has_air(scene)) pass_air(flight, surface, points, met);
  if (scene.shines) add_emission(flight, hits, surface, met);

  // Next-event estimation.
  if (chooses_lights(scene)) choose_light_kinds(flight, geometry, scattering, points);
  const LaneMask<L> of_all = scattering & points.samples_all;
  add_light_samples(flight, *scene.light, geometry, points, scattering & ~of_all);
  if (of_all.any()) add_light_samples(flight, *scene.all_lights, geometry, points, of_all);

  // Light that was baked, in place of what diffuse lobes would find.
  if (reads.any()) add_baked(flight, points, reads);
  if (reads.any() && flight.cell_errors != nullptr) add_cell_errors(flight, points, baked, reads);

  // Sample the surface; throughput, roulette, the next rays.
  return scatter_paths(flight, on, by, geometry, surface, points);
}

// The radiance [component][band][lane] of the rays of some lanes, to the end of their paths: the
// packet is followed alone.
template <typename L, typename Search>
OMMA_HD void trace_paths(const Flight<L, Search>& flight, LaneMask<L> on) {
  for (int i = 0; i < flight.components() * flight.stride(); ++i) flight.radiance[i] = 0;
  reset_paths<L>(flight.scene, flight.state, flight.memory);
  if (flight.passed != nullptr) clear<L>(*flight.passed);
  Spread spread = flight.state.gathers ? Spread::scattered : Spread::together;
  while (on.any()) {
    on = trace_flight(flight, on, spread).all();
    spread = Spread::scattered;
  }
}

// As trace_paths, of rays from the eye that are traced by themselves (aimed_rays.h).
template <typename L, typename Search>
OMMA_HD_CALLED void eval_lit_path(const SceneView& scene, Search& search, Packet<L>& packet,
                                  LaneMask<L> on, const PathMemory& memory, float* radiance) {
  PathState<L> state;
  trace_paths<L, Search>({scene, search, packet, state, memory, radiance, passed_in(scene, memory)},
                         on);
}

}  // namespace omma
