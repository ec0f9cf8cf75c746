// Surfaces that let light through and that rays have passed: several may lie in one place, so a ray
// goes on from a little before the one it met, and those it had are left out.
#pragma once

#include "omma/vec.h"
#include "physics/views/path_memory.h"
#include "physics/views/ray_packet.h"

namespace omma {

// Surfaces this near to each other, as a fraction of their distance, may come in any order: hits
// are computed with an error of about float's resolution, more on slanted and large triangles.
inline constexpr float same_place = 1e-5f;

// Where a ray that passes a surface at t looks for the next one: a little before it, as others may
// lie in the same place.
OMMA_HD float search_from(float t_m) {
  return t_m * (1.0f - same_place);
}

// Behind that place, where no more surfaces can be remembered there.
OMMA_HD float step_behind(float t_m) {
  return t_m * (1.0f + same_place) + 1e-30f;
}

// Forgets all surfaces.
template <typename L>
OMMA_HD void clear(const PassedSurfaces& passed) {
  for (int l = 0; l < L::count; ++l) passed.count[l] = 0;
}

// Remembers the surface that a ray met and passes, and moves its near end to where it goes on from.
template <int lanes>
OMMA_HD void pass(const PassedSurfaces& passed, int lane, RayPacket<lanes>& rays) {
  const float t = rays.t_far_m[lane], from = search_from(t);
  PassedSurface* const surfaces = passed.surface + lane * PassedSurfaces::capacity;
  int count = 0;
  for (int k = 0; k < passed.count[lane]; ++k)
    if (surfaces[k].t_m >= search_from(from)) surfaces[count++] = surfaces[k];
  float& near = rays.t_near_m[lane];
  if (count == PassedSurfaces::capacity) {
    passed.count[lane] = 0;
    near = step_behind(t);
    return;
  }
  surfaces[count] = {rays.instance[lane], rays.geometry[lane], rays.triangle[lane], t,
                     rays.u[lane],        rays.v[lane]};
  passed.count[lane] = count + 1;
  near = from > near ? from : near;
}

struct Triangle {
  Vec3d corner[3];
};

// A hit this near to an edge, in barycentric weight, may be one of the neighbour too: watertight
// intersection counts both where a weight is within float's resolution of zero.
inline constexpr float on_edge = 1e-6f;

OMMA_HD bool is_on_edge(float u, float v) {
  return u < on_edge || v < on_edge || u + v > 1 - on_edge;
}

// Whether a triangle that is hit on its edge covers what a ray sees that is moved a little.
OMMA_HD bool covers(const Triangle& t, float u, float v, Vec3d direction, Vec3d move) {
  const Vec3d e1 = t.corner[1] - t.corner[0], e2 = t.corner[2] - t.corner[0];
  const Vec3d p = cross(direction, e2);
  const double volume = dot(e1, p);
  if (volume == 0) return true;  // seen edge on
  // How the weights change (Moeller and Trumbore 1997).
  const double du = dot(move, p) / volume, dv = dot(direction, cross(move, e1)) / volume;
  return (u >= on_edge || du > 0) && (v >= on_edge || dv > 0) &&
         (u + v <= 1 - on_edge || du + dv < 0);
}

// Whether a ray has passed the surface that a candidate hit belongs to. `corners(instance,
// geometry, triangle)` gives a triangle; both that are asked for lie in one frame, as does the
// direction: that of the mesh, or the traced one where there is no instance.
//
// A ray that hits an edge or a corner meets all the triangles about it, which are one surface and
// count once, while triangles that lie upon each other are several. So of those hit on an edge
// after a first one only those count that cover what it covers, as the ray sees it: a point well
// inside the first, in no special place, so that edges of others do not lie along the way to it.
template <typename Corners>
OMMA_HD bool has_passed(const PassedSurfaces& passed, int lane, const PassedSurface& hit,
                        Vec3 direction, const Corners& corners) {
  const PassedSurface* first = nullptr;
  for (int k = 0; k < passed.count[lane]; ++k) {
    const PassedSurface& s = passed.surface[lane * PassedSurfaces::capacity + k];
    if (s.instance != hit.instance) continue;
    if (s.geometry == hit.geometry && s.triangle == hit.triangle) return true;
    if (first == nullptr && is_on_edge(s.u, s.v)) first = &s;
  }
  if (first == nullptr || !is_on_edge(hit.u, hit.v)) return false;
  if (first->geometry != hit.geometry && first->instance != none) return false;
  Vec3d move;
  {
    const Triangle a = corners(first->instance, first->geometry, first->triangle);
    const double inside[3] = {0.4741, 0.3107, 0.2152};
    const double weight[3] = {1.0 - static_cast<double>(first->u) - static_cast<double>(first->v),
                              static_cast<double>(first->u), static_cast<double>(first->v)};
    for (int k = 0; k < 3; ++k) move = move + a.corner[k] * (inside[k] - weight[k]);
  }
  return !covers(corners(hit.instance, hit.geometry, hit.triangle), hit.u, hit.v,
                 to_double(direction), move);
}

}  // namespace omma
