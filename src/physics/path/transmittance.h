// What is left of light that comes past what lets it straight through: sheets that cover what lies
// behind in part, thin glass, Gaussian splats.
#pragma once

#include "physics/lanes/lane_mask.h"
#include "physics/path/media.h"
#include "physics/path/path_state.h"
#include "physics/path/splat_light.h"
#include "physics/rays/hits.h"
#include "physics/rays/passed.h"
#include "physics/rays/search_rays.h"
#include "physics/surface/lit_surface.h"

namespace omma {

// Below this fraction what lies behind a surface that lets light by counts for nothing.
inline constexpr float least_passing = 1e-7f;

// Straight on through a part of a surface: what is left, [band][lane], of light from behind, where
// it covers little or is glass.
template <typename F>
OMMA_HD F passing(F alpha, F straight, F reflectance) {
  return (1.0f - alpha) + alpha * straight * reflectance;
}

// The same of what volumes absorb before surfaces that rays of some lanes met.
template <typename L>
OMMA_HD_CALLED void dim_by_volumes(const SceneView& scene, const RayPacket<L::count>& rays,
                                   const LitSurface<L>& surface, LaneMask<L> dimmed,
                                   const SpectraMemory& memory) {
  float part[L::count];
  dimmed.for_each([&](int l) {
    const float cosine = size_of_cosine(dot(vec_at(surface.normal, l), vec_at(rays.direction, l)));
    part[l] = bent_way(memory.media, surface, l, cosine);
  });
  absorb(scene, memory.media, surface, {dimmed, rays.t_far_m, part}, memory.throughput);
}

// Multiplies what has come through so far, memory.throughput, by what surfaces that shadow rays of
// some lanes met leave of it. Returns the lanes for which enough is left.
template <typename L>
OMMA_HD_CALLED LaneMask<L> dim_light(const SceneView& scene, const Packet<L>& shadow,
                                     const LitSurface<L>& surface, LaneMask<L> dimmed,
                                     const SpectraMemory& memory) {
  using F = typename L::F;
  float* const transmittance = memory.throughput;
  if (scene.has_volumes) dim_by_volumes<L>(scene, shadow.rays, surface, dimmed, memory);
  LaneMask<L> bright;
  for (int l = 0; l < L::count; l += L::width) {
    auto point = make_scatter_point(scatter_surface<L>(scene, shadow.rays, surface, l));
    if (scene.has_volumes)
      point.straight = point.straight * radiance_scale<L>(surface, memory.media, l, {});
    const auto dims = dimmed.at(l);
    F most{};
    for (int b = 0; b < scene.bands; ++b) {
      float* const at = transmittance + b * L::count + l;
      const F part = passing(load<F>(surface.alpha + l), point.straight,
                             load<F>(memory.reflectance + b * L::count + l));
      const F after = dims ? load<F>(at) * part : load<F>(at);
      store(at, after);
      most = after > most ? after : most;
    }
    bright.bits |= lane_bits(most > least_passing) << l;
  }
  return bright;
}

// Multiplies what has come through, memory.throughput, by what splats leave of it on the way of
// some lanes' shadow rays up to t_far_m.
template <typename L, typename Search>
OMMA_HD_CALLED void dim_by_splats(const SceneView& scene, Search& search, LaneMask<L> lanes,
                                  const float (&t_far_m)[L::count], Packet<L>& shadow,
                                  const SpectraMemory& memory) {
  using F = typename L::F;
  alignas(L::count * 4) float begin_m[L::count];
  for (int l = 0; l < L::count; ++l) {
    shadow.rays.t_far_m[l] = t_far_m[l];
    begin_m[l] = 0;
  }
  SplatLight<L> light;
  light.channels = 0;
  eval_splats<L>({*scene.splats, search.visits_of_trees()}, lanes, shadow.rays, begin_m, light,
                 nullptr);
  for (int b = 0; b < scene.bands; ++b)
    for (int l = 0; l < L::count; l += L::width) {
      float* const at = memory.throughput + b * L::count + l;
      store(at, load<F>(at) * load<F>(light.transmittance + l));
    }
}

// Of some lanes those whose rays met what lets light straight through.
template <typename L>
OMMA_HD LaneMask<L> lanes_let_on(const SceneView& scene, const Hits<L>& hits, LaneMask<L> met) {
  LaneMask<L> on;
  met.for_each([&](int l) {
    if (lets_rays_on(scene.materials[scene.meshes[hits.mesh[l]].material])) on.add(l);
  });
  return on;
}

// Shadow rays past what lets light straight through: the transmittance of the way, by band,
// is memory.throughput. They begin in memory.media. Returns the lanes that reach their light.
template <typename L, typename Search>
OMMA_HD_CALLED LaneMask<L> trace_transmittance(const SceneView& scene, Search& search,
                                               LaneMask<L> lanes, Packet<L>& shadow,
                                               const SpectraMemory& memory) {
  clear<L>(memory.passed);
  alignas(L::count * 4) float t_far_m[L::count];
  for (int l = 0; l < L::count; ++l) t_far_m[l] = shadow.rays.t_far_m[l];
  for (int i = 0; i < scene.bands * L::count; ++i) memory.throughput[i] = 1;
  LaneMask<L> on = lanes, reached;
  for (int flight = 0; on.any() && flight < most_flights; ++flight) {
    clear_hits<L>(shadow.rays);
    for (int l = 0; l < L::count; ++l) shadow.rays.t_far_m[l] = t_far_m[l];
    search_closest(search, on, shadow.rays, &memory.passed, Spread::scattered);
    Hits<L> hits;
    find_hits<L>(search.placed(), shadow, hits);
    const LaneMask<L> met = on & lanes_met(hits);
    reached |= on & ~met;
    on = lanes_let_on(scene, hits, met);
    if (!on.any()) break;

    // What is opaque is not looked at.
    for (int l = 0; l < L::count; ++l)
      if (!on.has(l)) hits.mesh[l] = -1;
    HitGeometry<L> geometry;
    eval_geometry<L>(scene, shadow.rays, hits, geometry);
    LitSurface<L> surface;
    eval_lit_surfaces<L>(scene, shadow, hits, geometry, memory, surface);
    on &= dim_light(scene, shadow, surface, on, memory);
    if (scene.has_volumes) pass_boundaries<L>(surface, on, {}, shadow.rays.t_far_m, memory.media);
    on.for_each([&](int l) { pass(memory.passed, l, shadow.rays); });
  }
  if (scene.has_volumes) absorb_to_end(scene, memory.media, reached, t_far_m, memory.throughput);
  if (scene.splats != nullptr && reached.any())
    dim_by_splats(scene, search, reached, t_far_m, shadow, memory);
  return reached;
}

}  // namespace omma
