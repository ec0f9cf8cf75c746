// Lights that are near, for next-event estimation: a direction from a point towards a lamp or a
// surface that shines, with its probability, and what comes from there if nothing is in the way.
// Light from afar, lamps and surfaces are chosen between, and one of many lamps or surfaces, by
// what they send to that point.
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

// A point in the frame of an instance's mesh, with a normal that measures as before.
OMMA_HD LitPoint point_in_mesh(const SceneView& scene, std::int32_t instance, const LitPoint& at) {
  const float* m = scene.frame_from_mesh + 12 * static_cast<std::ptrdiff_t>(instance);
  const Vec3 n = at.normal;
  return {place_before(m, at.position),
          {m[0] * n.x + m[4] * n.y + m[8] * n.z, m[1] * n.x + m[5] * n.y + m[9] * n.z,
           m[2] * n.x + m[6] * n.y + m[10] * n.z},
          at.rise_m};
}

// Probability per solid angle with which sample_surfaces gives the direction in which a ray from a
// point has met a triangle; 0 where it is not one that is sampled.
OMMA_HD float met_light_pdf(const SceneView& scene, const LightView& light, const MetTriangle& met,
                            const LitPoint& at, Vec3 direction) {
  if (light.emissive_count == 0) return 0.0f;
  const std::int32_t index = light.emissive_of_instance[met.instance];
  if (index < 0) return 0.0f;
  const EmissiveView& emissive = light.emissive[index];
  const float chosen = choose_light_probability(light.emissive_tree, at, index) *
                       light_tree_probability(emissive.triangles,
                                              point_in_mesh(scene, met.instance, at), met.triangle);
  if (!(chosen > 0.0f)) return 0.0f;
  const LightTriangle seen =
      see_triangle(scene, met.instance, emissive.mesh, met.triangle, at.position);
  if (!shines_towards(scene, emissive.mesh, seen, direction)) return 0.0f;
  return chosen * seen_triangle_pdf(seen, direction, met.distance_m);
}

// So many lamps are weighed one by one by what each sends to a point; of more a tree knows about
// where they are.
inline constexpr std::int32_t few_lamps = 16;

// A point that takes light from all around, or a mean over directions, in place of a cosine.
inline constexpr float mean_cosine = 0.5f;

OMMA_HD LitPoint from_lamps(const LightView& light, const LitPoint& at) {
  const float* origin = light.lamp_origin_m;
  return origin == nullptr
             ? at
             : LitPoint{at.position - Vec3{origin[0], origin[1], origin[2]}, at.normal, at.rise_m};
}

// About what a lamp sends to a point, all bands: gloss may send back much of what falls on it at
// grazing angles, so that no lamp above a surface counts for nothing.
OMMA_HD float lamp_irradiance(const LightView& light, std::int32_t lamp, const LitPoint& at) {
  const LampAt lit = eval_lamp_at(light.lamps[lamp], at.position);
  const Vec3 n = at.normal;
  const float length_2 = dot(n, n);
  if (!(length_2 > 0.0f)) return light.lamps[lamp].power * lit.scale * mean_cosine;
  const float cosine = dot(n, lit.direction);
  constexpr float least = 0.1f;
  return cosine > 0.0f ? light.lamps[lamp].power * lit.scale * fmaxf(cosine, least) : 0.0f;
}

// What all lamps send there, over that at 1 m (KindView).
OMMA_HD float eval_lamps(const LightView& light, const LitPoint& at) {
  if (light.lamp_count > few_lamps)
    return mean_cosine * eval_light_node(light.lamp_tree.nodes[0], at);
  float all = 0;
  for (std::int32_t i = 0; i < light.lamp_count; ++i) all += lamp_irradiance(light, i, at);
  return all / light.from_lamps.all;
}

// By what each sends, but for the part that is chosen evenly of those that send any.
OMMA_HD ChosenLight choose_of_few_lamps(const LightView& light, const LitPoint& at, float u) {
  float all = 0;
  std::int32_t lit = 0;
  for (std::int32_t i = 0; i < light.lamp_count; ++i) {
    const float sent = lamp_irradiance(light, i, at);
    all += sent;
    lit += sent > 0.0f ? 1 : 0;
  }
  if (lit == 0) return {};
  const float evenly = even_part(lit);
  const bool is_even = u < evenly;
  std::int32_t left = is_even ? choose_evenly(lit, u).index : lit - 1;
  float below = is_even ? INFINITY : (u - evenly) / (1.0f - evenly) * all;
  ChosenLight chosen;
  for (std::int32_t i = 0; i < light.lamp_count && left >= 0 && below >= 0.0f; ++i) {
    const float sent = lamp_irradiance(light, i, at);
    if (!(sent > 0.0f)) continue;
    below -= sent;
    --left;
    chosen = {i, in_part_evenly(sent / all, lit), 0.0f};
  }
  return chosen;
}

OMMA_HD ChosenLight choose_lamp(const LightView& light, const LitPoint& at, float u) {
  if (light.lamp_count == 1) return {0, 1.0f, 0.0f};
  if (light.lamp_count > few_lamps) return choose_light(light.lamp_tree, at, u);
  return choose_of_few_lamps(light, at, u);
}

OMMA_HD void sample_lamps(const LightView& light, const LitPoint& point, float u,
                          LightSample& sample) {
  const LitPoint at = from_lamps(light, point);
  const ChosenLight chosen = choose_lamp(light, at, u);
  if (chosen.index < 0) return;
  sample.index = chosen.index;
  const LampAt lit = eval_lamp_at(light.lamps[sample.index], at.position);
  sample.kind = LightKind::lamp;
  sample.is_delta = true;
  sample.direction = lit.direction;
  sample.distance_m = lit.distance_m;
  sample.scale = lit.scale;
  if (lit.scale > 0.0f) sample.pdf = chosen.probability;
}

// Three random numbers in [0, 1): for which light, and where on it.
struct LightNumbers {
  float which, u0, u1;
};

OMMA_HD void sample_surfaces(const SceneView& scene, const LightView& light, const LitPoint& at,
                             const LightNumbers& numbers, LightSample& sample) {
  const ChosenLight chosen = choose_light(light.emissive_tree, at, numbers.which);
  if (chosen.index < 0) return;
  const EmissiveView& emissive = light.emissive[chosen.index];
  const ChosenLight triangle = sample_light_tree(
      emissive.triangles, point_in_mesh(scene, emissive.instance, at), chosen.left);
  if (triangle.index < 0) return;
  sample.kind = LightKind::surface;
  sample.index = emissive.instance;
  sample.mesh = emissive.mesh;
  sample.triangle = triangle.index;
  const LightTriangle seen =
      see_triangle(scene, sample.index, sample.mesh, sample.triangle, at.position);
  const TriangleSample place = sample_triangle(seen, numbers.u0, numbers.u1);
  sample.direction = place.direction;
  sample.distance_m = place.distance_m;
  sample.u = place.u;
  sample.v = place.v;
  sample.normal = seen.normal * (1.0f / fmaxf(sqrtf(dot(seen.normal, seen.normal)), 1e-30f));
  for (const Vec3& corner : seen.corner) {
    const Vec3 c = corner + at.position;
    sample.reach_m = fmaxf(fmaxf(sample.reach_m, fabsf(c.x)), fmaxf(fabsf(c.y), fabsf(c.z)));
  }
  if (place.pdf > 0.0f && shines_towards(scene, sample.mesh, seen, place.direction))
    sample.pdf = place.pdf * chosen.probability * triangle.probability;
}

// Probabilities with which a light sample is from afar, of a lamp, on a surface; they add up to 1,
// or are all 0.
struct LightKinds {
  float far = 0, lamp = 0, surface = 0;
};

// By each kind's share of the irradiance of a point, the mean over bands:
//
//   p_k = ε / n + (1 - ε) mean_b E_k,b / Σ_j E_j,b,
//
// of the n kinds that send it light a part ε evenly, as any may be hidden. That surface and sky
// turn to each other is left out.
OMMA_HD LightKinds choose_kinds(const LightView& light, const LitPoint& at) {
  const KindView kinds[3] = {light.from_afar, light.from_lamps, light.from_surfaces};
  const int present = (kinds[0].all > 0.0f) + (kinds[1].all > 0.0f) + (kinds[2].all > 0.0f);
  float here[3] = {};
  for (int k = 0; k < 3; ++k)
    if (kinds[k].all > 0.0f) here[k] = mean_cosine;
  if (present > 1) {
    if (here[1] > 0.0f) here[1] = eval_lamps(light, from_lamps(light, at));
    if (here[2] > 0.0f) here[2] = mean_cosine * eval_light_node(light.emissive_tree.nodes[0], at);
  }
  float share[3] = {}, bands = 0;
  for (int b = 0; b < light.bands; ++b) {
    float sent[3] = {};
    for (int k = 0; k < 3; ++k)
      if (here[k] > 0.0f) sent[k] = here[k] * kinds[k].sent[b];
    const float all = sent[0] + sent[1] + sent[2];
    if (!(all > 0.0f)) continue;
    bands += 1.0f;
    for (int k = 0; k < 3; ++k) share[k] += sent[k] / all;
  }
  const int lit = (share[0] > 0.0f) + (share[1] > 0.0f) + (share[2] > 0.0f);
  const auto probability = [&](int k) {
    return share[k] > 0.0f ? in_part_evenly(share[k] / bands, lit) : 0.0f;
  };
  return {probability(0), probability(1), probability(2)};
}

// Towards a lamp or a surface that shines, of the kinds' probabilities; `numbers.which`: less that
// of light from afar.
OMMA_HD void sample_near_light(const SceneView& scene, const LightView& light, const LitPoint& at,
                               const LightKinds& kinds, LightNumbers numbers, LightSample& sample) {
  constexpr float below_1 = 0x1.fffffep-1f;
  sample = {};
  if (numbers.which < kinds.lamp) {
    sample_lamps(light, at, fminf(numbers.which / kinds.lamp, below_1), sample);
    sample.pdf *= kinds.lamp;
  } else if (kinds.surface > 0.0f) {
    const float u = (numbers.which - kinds.lamp) / kinds.surface;
    numbers.which = fminf(fmaxf(u, 0.0f), below_1);
    sample_surfaces(scene, light, at, numbers, sample);
    sample.pdf *= kinds.surface;
  }
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
