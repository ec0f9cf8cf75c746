// Surfaces that shine, as lights: one of them chosen, a triangle of it and a place on that, and the
// probability with which what a ray has met would have been.
#pragma once

#include "physics/light/emissive.h"
#include "physics/light/light_sample.h"
#include "physics/light/light_tree.h"

namespace omma {

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

}  // namespace omma
