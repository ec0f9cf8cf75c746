// Lights that are near, for next-event estimation: a direction from a position towards a lamp or a
// surface that shines, with its probability, and what comes from there if nothing is in the way.
// Light from afar, lamps and surfaces are chosen between with fixed probabilities, one of many
// lamps or surfaces by where they are.
#pragma once

#include "physics/light/emissive.h"
#include "physics/light/lamps.h"
#include "physics/light/light_tree.h"
#include "physics/surface/surface.h"

namespace omma {

enum class LightKind : std::uint8_t { dark, lamp, surface };

struct LightSample {
  LightKind kind = LightKind::dark;
  bool is_delta = false;  // a lamp: no path meets it, and `pdf` is the probability of choosing it
  Vec3 direction;         // unit, towards the light
  float distance_m = INFINITY;
  // Per solid angle, the choice of a light included; 0: no light comes.
  float pdf = 0;
  std::int32_t index = 0;               // of the lamp, or the surface's instance of the scene
  std::int32_t mesh = 0, triangle = 0;  // of a surface
  float u = 0, v = 0;                   // barycentric, where on it
  Vec3 normal;                          // of its triangle, unit
  float reach_m = 0;                    // the largest coordinate of that triangle's corners
  float scale = 1;                      // of a lamp's strength
};

// A triangle that a ray met, of an instance of the scene.
struct MetTriangle {
  std::int32_t instance, triangle;
  float distance_m;
};

// A place in the frame of an instance's mesh.
OMMA_HD Vec3 place_in_mesh(const SceneView& scene, std::int32_t instance, Vec3 position) {
  return place_before(scene.frame_from_mesh + 12 * static_cast<std::ptrdiff_t>(instance), position);
}

// Probability per solid angle with which sample_near_light gives the direction in which a ray from
// `position` has met a triangle; 0 where it is not one that is sampled.
OMMA_HD float met_light_pdf(const SceneView& scene, const LightView& light, const MetTriangle& met,
                            Vec3 position, Vec3 direction) {
  if (light.emissive_count == 0) return 0.0f;
  const std::int32_t index = light.emissive_of_instance[met.instance];
  if (index < 0) return 0.0f;
  const EmissiveView& emissive = light.emissive[index];
  const float chosen =
      light.emissive_probability * light_tree_probability(light.emissive_tree, position, index) *
      light_tree_probability(emissive.triangles, place_in_mesh(scene, met.instance, position),
                             met.triangle);
  if (!(chosen > 0.0f)) return 0.0f;
  const LightTriangle seen =
      see_triangle(scene, met.instance, emissive.mesh, met.triangle, position);
  if (!shines_towards(scene, emissive.mesh, seen, direction)) return 0.0f;
  return chosen * seen_triangle_pdf(seen, direction, met.distance_m);
}

// So many lamps are weighed one by one by what each sends to a place, range and cone included; of
// more a tree knows their distance alone.
inline constexpr std::int32_t few_lamps = 16;

OMMA_HD float lamp_irradiance(const LightView& light, std::int32_t lamp, Vec3 from_lamps) {
  float strength = 0;
  for (int k = 0; k < light.bands; ++k) strength += light.lamps[lamp].strength[k];
  return strength * eval_lamp_at(light.lamps[lamp], from_lamps).scale;
}

OMMA_HD ChosenLight choose_lamp(const LightView& light, Vec3 from_lamps, float u) {
  if (light.lamp_count > few_lamps) return sample_light_tree(light.lamp_tree, from_lamps, u);
  float all = 0;
  for (std::int32_t i = 0; i < light.lamp_count; ++i) all += lamp_irradiance(light, i, from_lamps);
  ChosenLight chosen{0, 0.0f, 0.0f};
  float sum = 0;
  for (std::int32_t i = 0; i < light.lamp_count && sum <= u * all; ++i) {
    const float sent = lamp_irradiance(light, i, from_lamps);
    if (!(sent > 0.0f)) continue;
    sum += sent;
    chosen = {i, sent / all, 0.0f};
  }
  return chosen;
}

OMMA_HD LightSample sample_lamps(const LightView& light, Vec3 position, float u) {
  LightSample sample;
  const float* origin = light.lamp_origin_m;
  const Vec3 from_lamps =
      origin == nullptr ? position : position - Vec3{origin[0], origin[1], origin[2]};
  const ChosenLight chosen = choose_lamp(light, from_lamps, u);
  sample.index = chosen.index;
  const LampAt at = eval_lamp_at(light.lamps[sample.index], from_lamps);
  sample.kind = LightKind::lamp;
  sample.is_delta = true;
  sample.direction = at.direction;
  sample.distance_m = at.distance_m;
  sample.scale = at.scale;
  if (at.scale > 0.0f) sample.pdf = light.lamp_probability * chosen.probability;
  return sample;
}

OMMA_HD LightSample sample_surfaces(const SceneView& scene, const LightView& light, Vec3 position,
                                    float u, float u0, float u1) {
  const ChosenLight chosen = sample_light_tree(light.emissive_tree, position, u);
  const EmissiveView& emissive = light.emissive[chosen.index];
  const ChosenLight triangle = sample_light_tree(
      emissive.triangles, place_in_mesh(scene, emissive.instance, position), chosen.left);
  LightSample sample;
  sample.kind = LightKind::surface;
  sample.index = emissive.instance;
  sample.mesh = emissive.mesh;
  sample.triangle = triangle.index;
  const LightTriangle seen =
      see_triangle(scene, sample.index, sample.mesh, sample.triangle, position);
  const TriangleSample place = sample_triangle(seen, u0, u1);
  sample.direction = place.direction;
  sample.distance_m = place.distance_m;
  sample.u = place.u;
  sample.v = place.v;
  sample.normal = seen.normal * (1.0f / fmaxf(sqrtf(dot(seen.normal, seen.normal)), 1e-30f));
  for (const Vec3& corner : seen.corner) {
    const Vec3 at = corner + position;
    sample.reach_m = fmaxf(fmaxf(sample.reach_m, fabsf(at.x)), fmaxf(fabsf(at.y), fabsf(at.z)));
  }
  if (place.pdf > 0.0f && shines_towards(scene, sample.mesh, seen, place.direction))
    sample.pdf = place.pdf * light.emissive_probability * chosen.probability * triangle.probability;
  return sample;
}

// Towards a lamp or a surface that shines; `left`: a random number in [0, 1) less the probability
// of light from afar.
OMMA_HD LightSample sample_near_light(const SceneView& scene, const LightView& light, Vec3 position,
                                      float left, float u0, float u1) {
  constexpr float below_1 = 0x1.fffffep-1f;
  if (left < light.lamp_probability)
    return sample_lamps(light, position, fminf(left / light.lamp_probability, below_1));
  if (light.emissive_probability > 0.0f) {
    const float u = (left - light.lamp_probability) / light.emissive_probability;
    return sample_surfaces(scene, light, position, fminf(fmaxf(u, 0.0f), below_1), u0, u1);
  }
  return {};
}

// What comes from where a sample looks, all bands, `components` of I, Q, U, at
// out[component * component_stride + band * band_stride]: radiance, or from a lamp irradiance
// across its direction.
OMMA_HD void eval_light_sample(const SceneView& scene, const LightSample& sample, int components,
                               float* out, int band_stride, int component_stride) {
  const LightView& light = *scene.light;
  for (int p = 0; p < components; ++p)
    for (int k = 0; k < light.bands; ++k) out[p * component_stride + k * band_stride] = 0;
  if (sample.kind == LightKind::lamp) {
    const float* strength = light.lamps[sample.index].strength;
    for (int k = 0; k < light.bands; ++k) out[k * band_stride] = strength[k] * sample.scale;
  } else if (sample.kind == LightKind::surface) {
    const MeshView& mesh = scene.meshes[sample.mesh];
    const float* matrix = scene.scatter[mesh.material].emission;
    const SurfaceHit place{sample.mesh, static_cast<std::uint32_t>(sample.triangle), sample.u,
                           sample.v, 0.0f};
    // Light from behind is not sampled, so that only cut-outs are asked for here.
    if (matrix == nullptr || !accept_hit(scene, place, false)) return;
    const Color<float> c = emitted_rgb(scene, mesh, point_of(place));
    const float alpha = eval_opacity(scene, mesh, point_of(place));
    for (int k = 0; k < light.bands; ++k) {
      const float* row = matrix + 3 * k;
      out[k * band_stride] = alpha * (c.r * row[0] + c.g * row[1] + c.b * row[2]);
    }
  }
}

}  // namespace omma
