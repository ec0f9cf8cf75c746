// Light that arrives at the ends of the paths of a packet: from afar, and from surfaces that shine.
#pragma once

#include "physics/light/far_light.h"
#include "physics/light/near_light.h"
#include "physics/path/flight.h"
#include "physics/path/polarized_paths.h"
#include "physics/surface/lit_surface.h"

namespace omma {

// One node of the sky for each direction of some lanes of a packet; `choice`: for what it is
// sampled.
template <typename L>
OMMA_HD void choose_nodes(const Packet<L>& packet, const PathState<L>& state, Choice choice,
                          LaneMask<L> lanes, SkyLookups<L>& places) {
  using U = typename L::U;
  for (int l = 0; l < L::count; l += L::width) {
    auto& place = places[l / L::width];
    auto chosen = place;
    choose_node(chosen,
                mix_bits_32(load<U>(packet.hash + l) + load<U>(packet.sample + l) * 0x9e3779b9u +
                            load<U>(state.flight + l) * 0x85ebca6bu +
                            (static_cast<std::uint32_t>(choice) + 1u) * 0x68bc21ebu));
    const auto is = lanes.at(l);
    place.along_column = is ? chosen.along_column : place.along_column;
    place.along_row = is ? chosen.along_row : place.along_row;
  }
}

// Adds light that arrives along the packet's rays, `light` [component][band][lane], with a weight
// for each lane, 0 for none:
//
//   radiance += w β M s,
//
// β the throughput of the path, M its Mueller matrix, s the light's Stokes vector. That is by the
// axes `axis`; where they are null light is unpolarised, and `light` has I alone.
template <typename L, typename Search>
OMMA_HD_CALLED void add_light(const Flight<L, Search>& flight, const float* weight,
                              const float (*axis)[L::count], const float* light) {
  using F = typename L::F;
  for (int l = 0; l < L::count; l += L::width) {
    const F w = load<F>(weight + l);
    const auto is_on = w != 0.0f;
    if (!any_lane(is_on)) continue;
    if (flight.scene.polarized) {
      add_polarized_light(flight, w, l, axis, light);
      continue;
    }
    for (int b = 0; b < flight.scene.bands; ++b) {
      const int at = b * L::count + l;
      const F scale = load<F>(flight.memory.throughput + at) * w;
      float* const sum = flight.radiance + at;
      store(sum, load<F>(sum) + keep(is_on, scale * load<F>(light + at)));
    }
  }
}

// Where the light from afar along the rays of some lanes is looked up. What lies at nodes is
// fetched from memory meanwhile.
template <typename L>
struct FarLookups {
  SkyLookups<L> on_sky;
  LaneMask<L> by_chance;  // lanes whose direction was sampled
  LaneMask<L> keeps;      // lanes of whose light more than I counts
  bool at_nodes;          // of the sky alone, else some lanes' are between them
};

template <typename L, typename Search>
OMMA_HD_CALLED void look_up_far(const Flight<L, Search>& flight, LaneMask<L> lanes,
                                FarLookups<L>& far) {
  using F = typename L::F;
  const SceneView& scene = flight.scene;
  const PathState<L>& state = flight.state;
  far.keeps = scene.polarized ? keeping_polarisation<L>(state) & lanes : LaneMask<L>{};
  far.by_chance =
      lanes & lanes_where<L>([&](int l) { return load<F>(state.density + l) < INFINITY; });
  far.at_nodes = far.by_chance == lanes;
  find_far<L>(*scene.light, flight.packet.rays.direction, lanes, far.on_sky);
  if (far.by_chance.any())
    choose_nodes<L>(flight.packet, state, Choice::light, far.by_chance, far.on_sky);
  if (!far.at_nodes) return;
  fetch_sky_nodes<L>(scene.light->sky, lanes, far.keeps, far.on_sky);
}

// Light from afar along the rays of some lanes, which met nothing. Next-event estimation could have
// found it too (direct_light.h): it counts by the balance heuristic, and wholly for rays from the
// eye.
template <typename L, typename Search>
OMMA_HD_CALLED void add_far(const Flight<L, Search>& flight, LaneMask<L> lanes,
                            const FarLookups<L>& far) {
  using F = typename L::F;
  using I = typename L::I;
  constexpr int n = L::count;
  const SceneView& scene = flight.scene;
  const LightView& light = *scene.light;
  const PathState<L>& state = flight.state;
  const Packet<L>& packet = flight.packet;
  float* const arriving = flight.memory.light;
  const float(&direction)[3][n] = packet.rays.direction;
  alignas(n * 4) float weight[n], pdf[n] = {}, axis[3][n] = {};
  const LaneMask<L> keeps = far.keeps & lanes, by_chance = far.by_chance & lanes;
  const LaneMask<L> with_discs =
      state.gathers
          ? lanes & lanes_where<L>([&](int l) { return load<I>(state.scatterings + l) > 0; })
          : lanes;
  const LaneMask<L> of_all = by_chance & having_sampled_all(scene, state);
  if (by_chance.any()) find_far_pdf<L>(light, direction, far.on_sky, by_chance & ~of_all, pdf);
  if (of_all.any()) find_far_pdf<L>(*scene.all_lights, direction, far.on_sky, of_all, pdf);
  for (int l = 0; l < n; l += L::width)
    store(pdf + l, load<F>(pdf + l) * load<F>(state.chose_far + l));
  eval_sky_lanes<L>(light, {direction, far.on_sky, lanes, keeps, far.at_nodes}, flight.components(),
                    arriving);
  alignas(n * 4) float acceptance_sr[n];
  for (int l = 0; l < n; l += L::width)
    store(acceptance_sr + l, by_chance.at(l) ? F{} : load<F>(packet.acceptance_sr + l));
  add_disc_light<L>(light, {direction, packet.rays.origin}, with_discs, acceptance_sr, arriving);
  for (int l = 0; l < n; l += L::width) {
    const F one = broadcast<F>(1.0f), density = load<F>(state.density + l);
    const F weighed = balance(density, load<F>(pdf + l));
    store(weight + l, keep(lanes.at(l), by_chance.at(l) ? weighed : one));
  }
  if (keeps.any()) vertical_axes<L>(direction, axis);
  add_light(flight, weight, axis, arriving);
}

// What surfaces that were met shine with themselves, weighed against next-event estimation alike.
template <typename L, typename Search>
OMMA_HD_CALLED void add_emission(const Flight<L, Search>& flight, const Hits<L>& hits,
                                 const LitSurface<L>& surface, LaneMask<L> lanes) {
  const SceneView& scene = flight.scene;
  const PathState<L>& state = flight.state;
  const RayPacket<L::count>& rays = flight.packet.rays;
  const LaneMask<L> of_all = having_sampled_all(scene, state);
  alignas(L::count * 4) float weight[L::count] = {};
  bool any = false;
  lanes.for_each([&](int l) {
    if (scene.scatter[surface.material[l]].emission == nullptr) return;
    if (state.gathers && state.scatterings[l] == 0) return;
    weight[l] = surface.alpha[l];
    if (!is_from_eye(state.density[l])) {
      const float pdf = met_light_pdf(
          scene, of_all.has(l) ? *scene.all_lights : *scene.light,
          {hits.instance[l], int_of(rays.triangle[l]), rays.t_far_m[l], rays.u[l], rays.v[l]},
          {vec_at(rays.origin, l), vec_at(state.lit_normal, l)}, vec_at(rays.direction, l));
      weight[l] *= power_heuristic(state.density[l], state.chose_surface[l] * pdf);
    }
    any = true;
  });
  if (any) add_light<L>(flight, weight, nullptr, flight.memory.emission);
}

}  // namespace omma
