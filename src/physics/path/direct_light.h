// Next-event estimation for the lanes of a packet: a light sampled for each surface that was met, a
// shadow ray to it or a look at the sun's map, and what comes to the eye of it. Of lobes j with
// sampling probabilities q_j the estimate is
//
//   Σ_j w_j f_j(ω) cos θ L(ω) V(ω) / p(ω),    w_j = w(p, q_j p_j),
//
// p the density of the light sample, p_j that of lobe j, w a heuristic (path_state.h) of each lobe
// by itself, as the path may find the same light by that lobe. Lamps have no size, no path meets
// them: there w = 1.
//
// Where a path from the eye is scattered first, light from afar and near light have a sample each:
// chosen between, a lamp beside moonlight would be taken by 15 or 16 of 16 rays, the same number in
// each scramble, and no standard error would show the 16th part that is missing or too much.
#pragma once

#include "physics/light/near_light.h"
#include "physics/light/sun_map.h"
#include "physics/path/air.h"
#include "physics/path/baked_scatter.h"
#include "physics/path/transmittance.h"
#include "physics/rays/search_rays.h"

namespace omma {

// A light that lies on a surface is not hidden by that surface: a shadow ray looks this far.
inline constexpr float up_to_light = 1.0f - 1e-4f;

// A sample of light for each lane of a packet, all [lane].
template <typename L>
struct LightSamples {
  static constexpr int n = L::count;
  alignas(n * 4) float direction[3][n];  // unit, towards the light; zeros where there is none
  alignas(n * 4) float density[n];       // per solid angle, choice of light included; 0: none
  alignas(n * 4) float is_delta[n];      // 1 for lamps, which no path meets
  alignas(n * 4) float distance_m[n];
  LaneMask<L> from_afar, near;  // lanes with light from the sky and discs, and with other light
  bool near_alone = false;      // whether light from afar has had a sample of its own
  bool has_sky = false;         // whether that from afar may be the sky's
  SkyLookups<L> on_sky;         // of those from afar
  LightSample other[n];         // of those that are near
};

// Shadow rays from where they have left their surfaces end where they would have left that of the
// light: either may be large beside the distance, and either would hide the light.
template <typename L>
OMMA_HD void end_at_lights(const HitGeometry<L>& geometry, const LightSamples<L>& lights,
                           RayPacket<L::count>& rays) {
  for (int l = 0; l < L::count; ++l) rays.t_far_m[l] = INFINITY;
  lights.near.for_each([&](int l) {
    if (!(lights.distance_m[l] < INFINITY)) return;
    const LightSample& sample = lights.other[l];
    const Vector3<float> direction = vector_of(sample.direction);
    const Vector3<float> begin = vector_of(vec_at(rays.origin, l) - vec_at(geometry.position, l));
    const Vector3<float> end = leave_surface(direction * lights.distance_m[l],
                                             vector_of(sample.normal), sample.reach_m, -direction);
    const Vector3<float> way = end - begin;
    const float length = sqrtf(dot(way, way));
    if (length > 0.0f) store_vector(rays.direction, l, without_noise(way * (1.0f / length)));
    rays.t_far_m[l] = length * up_to_light;
  });
}

// Of a lane's surface: such as nothing goes through takes light from the viewer's side alone.
template <typename L>
OMMA_HD LitPoint lit_point(const Packet<L>& packet, const HitGeometry<L>& geometry,
                           LaneMask<L> two_sided, int l) {
  const Vec3 normal = vec_at(geometry.normal, l);
  const float away = dot(normal, vec_at(packet.rays.direction, l));
  if (two_sided.has(l)) return {vec_at(geometry.position, l), {}};
  return {vec_at(geometry.position, l), normal * (away > 0.0f ? -1.0f : 1.0f),
          geometry.reach_m[l] * leave_resolutions};
}

// How a light is chosen for the surfaces of some lanes.
template <typename L, typename Search>
OMMA_HD_CALLED void choose_light_kinds(const Flight<L, Search>& flight,
                                       const HitGeometry<L>& geometry, LaneMask<L> scattering,
                                       ScatteringPacket<L>& points) {
  using F = typename L::F;
  const SceneView& scene = flight.scene;
  points.two_sided = lanes_where<L>([&](int l) {
    F through{};
    for (int b = 0; b < scene.bands; ++b)
      through = through + load<F>(flight.memory.transmittance + b * L::count + l);
    return through > 0.0f;
  });
  scattering.for_each([&](int l) {
    const LightView& light = points.samples_all.has(l) ? *scene.all_lights : *scene.light;
    const bool sample_each = flight.state.scatterings[l] == 0 && !flight.state.gathers;
    const LightKinds kinds =
        choose_kinds(light, lit_point(flight.packet, geometry, points.two_sided, l), sample_each);
    points.far[l] = kinds.far;
    points.lamp[l] = kinds.lamp;
    points.surface[l] = kinds.surface;
  });
}

template <typename L, typename Search>
OMMA_HD_CALLED void sample_lights(const Flight<L, Search>& flight, const LightView& light,
                                  const HitGeometry<L>& geometry, const ScatteringPacket<L>& points,
                                  LaneMask<L> scattering, LightSamples<L>& lights) {
  using F = typename L::F;
  constexpr int n = L::count;
  const Packet<L>& packet = flight.packet;
  const PathState<L>& state = flight.state;
  for (int l = 0; l < n; l += L::width) {
    store_vector(lights.direction, l, Vector3<F>{});
    store(lights.density + l, F{});
    store(lights.is_delta + l, F{});
    store(lights.distance_m + l, broadcast<F>(INFINITY));
  }
  lights.from_afar = lights.near = {};
  lights.has_sky = light.sky.probability > 0.0f;
  const bool has_near = has_near_light(light);
  if (!has_near && !(light.from_afar.all > 0.0f)) return;

  // Which light, and where on it.
  alignas(n * 4) float which[n] = {}, u0[n], u1[n];
  for (int l = 0; l < n; l += L::width) {
    if (has_near) store(which + l, choose<L>(packet, state, l, Choice::light).x);
    const auto on_light = choose<L>(packet, state, l, Choice::place_on_light);
    store(u0 + l, on_light.x);
    store(u1 + l, on_light.y);
  }
  lights.from_afar = lights.near_alone ? LaneMask<L>{} : scattering;
  if (has_near)
    lights.from_afar &=
        lanes_where<L>([&](int l) { return load<F>(which + l) < load<F>(points.far + l); });
  lights.near = scattering & ~lights.from_afar;

  // The sky and its discs: all lanes at once.
  sample_far<L>(light, u0, u1, lights.from_afar, lights.direction);
  if (lights.has_sky)
    find_far<L>(light, lights.direction, lights.from_afar, lights.on_sky);
  find_far_pdf<L>(light, lights.direction, lights.on_sky, lights.from_afar, lights.density);
  if (has_near)
    for (int l = 0; l < n; l += L::width)
      store(lights.density + l, load<F>(lights.density + l) * load<F>(points.far + l));
  if (lights.has_sky)
    choose_nodes<L>(packet, state, Choice::place_on_light, lights.from_afar, lights.on_sky);

  // Lamps and surfaces that shine: lane by lane.
  lights.near.for_each([&](int l) {
    const float from_far = lights.near_alone ? 0.0f : points.far[l];
    LightSample& sample = lights.other[l];
    sample_near_light(flight.scene, light, lit_point(packet, geometry, points.two_sided, l),
                      {points.far[l], points.lamp[l], points.surface[l]},
                      {which[l] - from_far, u0[l], u1[l]}, sample);
    store_vector(lights.direction, l, vector_of(sample.direction));
    lights.density[l] = sample.pdf;
    lights.is_delta[l] = sample.is_delta ? 1.0f : 0.0f;
    lights.distance_m[l] = sample.distance_m;
  });
}

// Shadow rays: of some lanes those whose light is not hidden. What surfaces that let light through
// leave of it is in memory.shadow.throughput then.
template <typename L, typename Search>
OMMA_HD_CALLED LaneMask<L> trace_shadow_rays(const Flight<L, Search>& flight,
                                             const HitGeometry<L>& geometry,
                                             const LightSamples<L>& lights, LaneMask<L> lanes) {
  if (!lanes.any()) return {};
  Packet<L> shadow;
  clear<L>(shadow.rays);
  leave_surfaces<L>(geometry, lights.direction, shadow.rays);
  for (int l = 0; l < L::count; ++l) {
    shadow.rays.mask[l] = flight.packet.light_sees;
    shadow.footprint_rad[l] = 0;
  }
  end_at_lights(geometry, lights, shadow.rays);
  if (flight.scene.has_volumes) begin_in<L>(flight.memory.shadow.media, flight.memory.media);
  if (lets_through(flight.scene))
    return trace_transmittance<L>(flight.scene, flight.search, lanes, shadow, flight.memory.shadow);
  return lanes & ~search_occluded(flight.search, lanes, shadow.rays);
}

// How much of each lane's light is seen, 0 to 1: of the sun by its map where there is one and
// nothing else is sampled from afar, else by shadow rays.
template <typename L, typename Search>
OMMA_HD void eval_visibility(const Flight<L, Search>& flight, const HitGeometry<L>& geometry,
                             const LightSamples<L>& lights, LaneMask<L> asked,
                             float (&visible)[L::count]) {
  using F = typename L::F;
  const bool has_map = flight.scene.sun_map != nullptr && !lights.has_sky;
  const LaneMask<L> mapped = has_map ? asked & lights.from_afar : LaneMask<L>{};
  const LaneMask<L> open = trace_shadow_rays(flight, geometry, lights, asked & ~mapped);
  for (int l = 0; l < L::count; l += L::width)
    store(visible + l, keep(open.at(l), broadcast<F>(1.0f)));
  if (!mapped.any()) return;
  alignas(L::count * 4) float by_map[L::count];
  eval_sun_map<L>(*flight.scene.sun_map, geometry, by_map);
  for (int l = 0; l < L::count; l += L::width)
    store(visible + l, mapped.at(l) ? load<F>(by_map + l) : load<F>(visible + l));
}

// What arrives of the lights of some lanes that are seen, in memory.light: [component][band][lane].
template <typename L, typename Search>
OMMA_HD_CALLED void eval_lights(const Flight<L, Search>& flight, const HitGeometry<L>& geometry,
                                const LightSamples<L>& lights, LaneMask<L> seen) {
  const SceneView& scene = flight.scene;
  const LightView& light = *scene.light;
  const int components = flight.components(), stride = flight.stride();
  float* const arriving = flight.memory.light;
  const LaneMask<L> far_seen = seen & lights.from_afar;
  eval_sky_lanes<L>(
      light,
      {lights.direction, lights.on_sky, lights.has_sky ? far_seen : LaneMask<L>{}, far_seen, true},
      components, arriving);
  (seen & lights.near).for_each([&](int l) {
    eval_light_sample(scene, lights.other[l], components, arriving + l, L::count, stride);
  });
  if (has_air(scene))
    dim_by_air<L>(scene, seen & lights.near, lights.distance_m, components, arriving);
  add_disc_light<L>(light, {lights.direction, geometry.position}, far_seen, nullptr, arriving);
  if (lets_through(scene))
    for (int c = 0; c < components; ++c)
      for (int i = 0; i < stride; ++i)
        arriving[c * stride + i] *= flight.memory.shadow.throughput[i];
}

// Adds what the surfaces of some lanes send to the eye of the light that was sampled for them;
// `scattered`: how they scatter it, weighed and over its density.
template <typename L, typename Search>
OMMA_HD void add_direct_light(const Flight<L, Search>& flight, const HitGeometry<L>& geometry,
                              const LightSamples<L>& lights, const ScatteringPacket<L>& points,
                              const Scattered<L>& scattered, LaneMask<L> scattering) {
  using F = typename L::F;
  constexpr int n = L::count;
  const SceneView& scene = flight.scene;
  const LaneMask<L> asked =
      scattering & lanes_where<L>([&](int l) {
        const F any = load<F>(scattered.reflected + l) + load<F>(scattered.transmitted + l) +
                      load<F>(scattered.dielectric[0] + l) + load<F>(scattered.metal + l) +
                      load<F>(scattered.coat[0] + l);
        return load<F>(lights.density + l) > 0.0f && any > 0.0f;
      });
  if (!asked.any()) return;
  const SkyView& sky = scene.light->sky;
  const LaneMask<L> from_sky = lights.has_sky ? asked & lights.from_afar : LaneMask<L>{};
  if (from_sky.any())
    fetch_sky_nodes<L>(sky, from_sky, scene.polarized ? from_sky : LaneMask<L>{}, lights.on_sky);

  // V: how much of it is seen.
  alignas(n * 4) float visible[n];
  eval_visibility(flight, geometry, lights, asked, visible);
  const auto seen = lanes_where<L>([&](int l) { return load<F>(visible + l) > 0.0f; });
  if (!seen.any()) return;

  // L: what arrives.
  eval_lights(flight, geometry, lights, seen);

  // f cos θ w / p, and on to the eye. Scattered, light is by the rays' own axes.
  scatter_light(flight, points, scattered, lights.direction, flight.memory.light);
  add_light(flight, visible, flight.packet.reference, flight.memory.light);
}

// Samples a light for the surface of each of some lanes, one that is near if `near_alone`, and adds
// what it sends to the eye.
template <typename L, typename Search>
OMMA_HD_CALLED void add_light_sample(const Flight<L, Search>& flight, const LightView& light,
                                     const HitGeometry<L>& geometry,
                                     const ScatteringPacket<L>& points, LaneMask<L> scattering,
                                     bool near_alone) {
  LightSamples<L> lights;
  Scattered<L> scattered;
  lights.near_alone = near_alone;
  sample_lights(flight, light, geometry, points, scattering, lights);
  scatter_light_samples<L>(points, lights.direction, lights.density, lights.is_delta, lights.near,
                           scattered);
  add_direct_light(flight, geometry, lights, points, scattered, scattering);
}

// One sample for each surface, or one from afar and one near (LightKinds).
template <typename L, typename Search>
OMMA_HD void add_light_samples(const Flight<L, Search>& flight, const LightView& light,
                               const HitGeometry<L>& geometry, const ScatteringPacket<L>& points,
                               LaneMask<L> scattering) {
  using F = typename L::F;
  add_light_sample(flight, light, geometry, points, scattering, false);
  if (!has_near_light(light)) return;
  const LaneMask<L> each = scattering & lanes_where<L>([&](int l) {
                             const F near = load<F>(points.lamp + l) + load<F>(points.surface + l);
                             return load<F>(points.far + l) + near > 1.5f;
                           });
  if (each.any()) add_light_sample(flight, light, geometry, points, each, true);
}

}  // namespace omma
