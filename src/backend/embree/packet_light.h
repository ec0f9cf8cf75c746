// What the rays of a packet bring: trace, surfaces, background, and on behind surfaces that let
// light through. Included by block.cpp alone, once per instruction set.
#pragma once

#include "backend/embree/packet.h"
#include "physics/path.h"

namespace omma::OMMA_ISA {
namespace {

// What each lane hit.
struct Hits {
  alignas(64) std::int32_t mesh[lanes];  // index, -1 for none
  alignas(64) float footprint_m[lanes];  // of the ray there, in metres of the mesh
};

void find_meshes(const EmbreeTracer& tracer, const Packet& packet, Hits& hits) {
  const RTCRayHit16& rays = packet.rays;
  static_assert(sizeof(PlacedMesh) == 8);
  for (int l = 0; l < lanes; l += lane_width) {
    const Ints geometry = load<Ints>(rays.hit.geomID + l);
    const Ints instance = load<Ints>(rays.hit.instID[0] + l);
    const Ints top = instance < 0 ? geometry : instance;  // an invalid id is -1
    const Pair<Ints> placed = gather_pair(&tracer.placed.data()->mesh, top < 0 ? top * 0 : top);
    store(hits.mesh + l, geometry < 0 ? geometry : placed.first);
    store(hits.footprint_m + l, load<Floats>(packet.footprint_rad + l) *
                                    load<Floats>(rays.ray.tfar + l) * float_of(placed.second));
  }
}

// Mesh by mesh: mostly all lanes see the same one.
void eval_surfaces(const SceneView& scene, const RTCHit16& hit, const Hits& hits,
                   PacketLight& light) {
  const std::int32_t(&mesh)[lanes] = hits.mesh;
  unsigned left = 0;
  for (int l = 0; l < lanes; l += lane_width) left |= lane_bits(load<Ints>(mesh + l) >= 0) << l;
  while (left != 0) {
    const std::int32_t current = mesh[__builtin_ctz(left)];
    unsigned members = 0;
    for (int l = 0; l < lanes; l += lane_width)
      members |= lane_bits(load<Ints>(mesh + l) == current) << l;
    left &= ~members;
    for (int l = 0; l < lanes; l += lane_width) {
      if ((members >> l & ((1u << lane_width) - 1)) == 0) continue;
      const Ints is_member = load<Ints>(mesh + l) == current;
      // Lanes of other meshes, and without a hit, hold anything; they go through as zeros.
      const Ints triangle = load<Ints>(hit.primID + l) & is_member;
      const auto of_members = [&](const float* p) {
        return float_of(load<Ints>(p + l) & is_member);
      };
      const SurfaceLight<Floats> s =
          eval_surface(scene, scene.meshes[current],
                       SurfacePoint<Floats, Ints>{triangle, of_members(hit.u), of_members(hit.v),
                                                  of_members(hits.footprint_m)});
      for (int c = 0; c < channel_count; ++c)
        store(light.channel[c] + l, is_member ? s.channel[c] : load<Floats>(light.channel[c] + l));
      store(light.alpha + l, is_member ? s.alpha : load<Floats>(light.alpha + l));
    }
  }
}

// Background of all lanes at once.
void background_radiance(const SceneView& scene, const Packet& packet,
                         float (&out)[channel_count][lanes]) {
  const RTCRay16& ray = packet.rays.ray;
  switch (scene.background.type) {
    case BackgroundType::constant:
      for (int l = 0; l < lanes; ++l) {
        out[0][l] = scene.background.color.x;
        out[1][l] = scene.background.color.y;
        out[2][l] = scene.background.color.z;
      }
      return;
    case BackgroundType::simple_sky:
      for (int l = 0; l < lanes; ++l) {
        const Radiance r = eval_simple_sky({ray.dir_x[l], ray.dir_y[l], ray.dir_z[l]});
        for (int c = 0; c < channel_count; ++c) out[c][l] = r.channel[c];
      }
      return;
    case BackgroundType::test_pattern:
    case BackgroundType::image:
      for (int l = 0; l < lanes; ++l) {
        const Radiance r = eval_background(scene, {ray.dir_x[l], ray.dir_y[l], ray.dir_z[l]},
                                           packet.footprint_rad[l]);
        for (int c = 0; c < channel_count; ++c) out[c][l] = r.channel[c];
      }
      return;
  }
}

// Opaque scenes: one trace, one surface or the background.
void shade_opaque(const BlockContext& context, Packet& packet, const int* valid,
                  IntersectArguments& arguments) {
  prepare(packet.rays);
  closest(*context.tracer, valid, packet.rays, arguments);
  Hits hits;
  find_meshes(*context.tracer, packet, hits);
  unsigned misses = 0;
  for (int l = 0; l < lanes; l += lane_width)
    misses |= lane_bits(load<Ints>(hits.mesh + l) < 0) << l;
  if (misses != 0) background_radiance(*context.scene, packet, packet.light.channel);
  eval_surfaces(*context.scene, packet.rays.hit, hits, packet.light);
}

// Remembers the surface that a ray met and passes, and where it goes on from.
void pass(PassedSurfaces& passed, int lane, RTCRayHit16& rays) {
  const float t = rays.ray.tfar[lane], from = search_from(t);
  PassedSurface(&surfaces)[PassedSurfaces::room] = passed.surface[lane];
  int count = 0;
  for (int k = 0; k < passed.count[lane]; ++k)
    if (surfaces[k].t_m >= search_from(from)) surfaces[count++] = surfaces[k];
  float& near = rays.ray.tnear[lane];
  if (count == PassedSurfaces::room) {
    passed.count[lane] = 0;
    near = step_behind(t);
    return;
  }
  surfaces[count] = {rays.hit.instID[0][lane], rays.hit.geomID[lane], rays.hit.primID[lane], t,
                     rays.hit.u[lane],         rays.hit.v[lane]};
  passed.count[lane] = count + 1;
  near = from > near ? from : near;
}

// Scenes with surfaces that let light through: on behind each, until nothing gets through.
void shade_blended(const BlockContext& context, Packet& packet, const int* valid,
                   IntersectArguments& arguments) {
  Path paths[lanes];
  PassedSurfaces passed;
  arguments.context.passed = &passed;
  alignas(64) float background[channel_count][lanes];
  alignas(64) int active[lanes];
  for (int l = 0; l < lanes; ++l) active[l] = valid[l];
  bool any = true;
  while (any) {
    prepare(packet.rays);
    closest(*context.tracer, active, packet.rays, arguments);
    background_radiance(*context.scene, packet, background);
    Hits hits;
    find_meshes(*context.tracer, packet, hits);
    eval_surfaces(*context.scene, packet.rays.hit, hits, packet.light);
    any = false;
    for (int l = 0; l < lanes; ++l) {
      if (active[l] == 0) continue;
      if (hits.mesh[l] < 0) {
        add_background(paths[l], {{background[0][l], background[1][l], background[2][l]}});
        active[l] = 0;
        continue;
      }
      SurfaceLight<float> light;
      for (int c = 0; c < channel_count; ++c) light.channel[c] = packet.light.channel[c][l];
      light.alpha = packet.light.alpha[l];
      const bool on = add_surface(paths[l], light);
      active[l] = on ? -1 : 0;
      any = any || on;
      if (on) pass(passed, l, packet.rays);
    }
  }
  arguments.context.passed = nullptr;
  for (int l = 0; l < lanes; ++l)
    for (int c = 0; c < channel_count; ++c)
      packet.light.channel[c][l] = paths[l].radiance.channel[c];
}

}  // namespace
}  // namespace omma::OMMA_ISA
