// Light gathered along one ray through surfaces that cover it in part, front to back. A backend
// gives one thing, the closest accepted hit; these steps are shared by all of them.
#pragma once

#include "physics/background.h"
#include "physics/surface.h"

namespace omma {

struct Path {
  Radiance radiance;
  float throughput = 1;  // share of what lies behind that still gets through
};

// Below this share the rest cannot change a response: less than a float's resolution of 1.
inline constexpr float least_throughput = 1e-7f;

// Surfaces this near to each other, as a share of their distance, may come in any order: hits are
// computed with an error of about float's resolution, more on slanted and large triangles.
inline constexpr float same_place = 1e-5f;

// Where a ray that passes a surface at t looks for the next one: a little before it, as others may
// lie in the same place. A backend leaves out those that the ray has passed.
OMMA_HD float search_from(float t_m) {
  return t_m * (1.0f - same_place);
}

// Behind that place, for a backend that can remember no more surfaces there.
OMMA_HD float step_behind(float t_m) {
  return t_m * (1.0f + same_place) + 1e-30f;
}

// Adds a surface; true where the ray goes on behind it.
OMMA_HD bool add_surface(Path& path, const SurfaceLight<float>& light) {
  for (int c = 0; c < channel_count; ++c)
    path.radiance.channel[c] += path.throughput * light.alpha * light.channel[c];
  path.throughput *= 1 - light.alpha;
  return path.throughput > least_throughput;
}

OMMA_HD void add_background(Path& path, const Radiance& radiance) {
  for (int c = 0; c < channel_count; ++c)
    path.radiance.channel[c] += path.throughput * radiance.channel[c];
}

// Radiance along one ray with a footprint of that width. `trace(t_near_m, hit, t_m)` finds the
// closest accepted hit at or beyond t_near that it has not found before, and the footprint there;
// false for none. Packet backends run the same steps lane by lane.
template <typename Trace>
OMMA_HD Radiance eval_path(const SceneView& scene, Vec3 direction, float footprint_rad,
                           float t_near_m, Trace trace) {
  Path path;
  for (;;) {
    SurfaceHit hit;
    float t_m = 0;
    if (!trace(t_near_m, hit, t_m)) {
      add_background(path, eval_background(scene, direction, footprint_rad));
      return path.radiance;
    }
    const SurfaceLight<float> light = eval_surface(scene, scene.meshes[hit.mesh], point_of(hit));
    if (!add_surface(path, light)) return path.radiance;
    const float from = search_from(t_m);
    t_near_m = from > t_near_m ? from : t_near_m;
  }
}

}  // namespace omma
