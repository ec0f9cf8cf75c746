// Surfaces that shine, as lights: one of them chosen, a triangle of it and a place on that, and the
// probability with which what a ray has met would have been.
#pragma once

#include "physics/light/emissive.h"
#include "physics/light/light_sample.h"
#include "physics/light/light_tree.h"

namespace omma {

// A triangle that a ray met, of an instance of the scene, and the barycentric weights of its second
// and third corner there.
struct MetTriangle {
  std::int32_t instance, triangle;
  float distance_m, u, v;
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
  const std::int32_t number = met.triangle * emissive.divisions * emissive.divisions +
                              subtriangle_at(met.u, met.v, emissive.divisions);
  const float chosen =
      choose_light_probability(light.emissive_tree, at, index) *
      light_tree_probability(emissive.triangles, point_in_mesh(scene, met.instance, at), number);
  if (!(chosen > 0.0f)) return 0.0f;
  const LightTriangle seen = see_triangle(scene, emissive, number, at.position);
  if (!shines_towards(scene, emissive.mesh, seen, direction)) return 0.0f;
  return chosen * seen_triangle_pdf(seen, direction, met.distance_m);
}

OMMA_HD void sample_surfaces(const SceneView& scene, const LightView& light, const LitPoint& at,
                             const LightNumbers& numbers, LightSample& sample) {
  const ChosenLight chosen = choose_light(light.emissive_tree, at, numbers.which);
  if (chosen.index < 0) return;
  const EmissiveView& emissive = light.emissive[chosen.index];
  const ChosenLight part = sample_light_tree(
      emissive.triangles, point_in_mesh(scene, emissive.instance, at), chosen.left);
  if (part.index < 0) return;
  const std::int32_t parts = emissive.divisions * emissive.divisions;
  sample.kind = LightKind::surface;
  sample.index = emissive.instance;
  sample.mesh = emissive.mesh;
  sample.triangle = part.index / parts;
  const LightTriangle seen = see_triangle(scene, emissive, part.index, at.position);
  const TriangleSample place = sample_triangle(seen, numbers.u0, numbers.u1);
  sample.direction = place.direction;
  sample.distance_m = place.distance_m;
  const Subtriangle sub = subtriangle(part.index - sample.triangle * parts, emissive.divisions);
  sample.u = sub.u + sub.scale * place.u;
  sample.v = sub.v + sub.scale * place.v;
  sample.normal = seen.normal * (1.0f / fmaxf(sqrtf(dot(seen.normal, seen.normal)), 1e-30f));
  sample.reach_m = seen.reach_m;
  if (place.pdf > 0.0f && shines_towards(scene, sample.mesh, seen, place.direction))
    sample.pdf = place.pdf * chosen.probability * part.probability;
}

}  // namespace omma
