// Where rays meet triangles, watertight along shared edges: a ray passes each edge on one side or
// the other, told by the sign of a number (Pluecker coordinates: Platis, Theoharis 2003,
// doi:10.1080/10867651.2003.10487584) that is exactly the opposite for the triangle on the other
// side, whatever the rounding: it is made of sums and differences of the edge's two corners alone.
// Nothing is fused (-ffp-contract=off).
#pragma once

#include "physics/lanes/vector3.h"
#include "physics/search/search_lanes.h"

namespace omma {

// A ray is inside where no weight is below minus that fraction of their sum: where the rounding of
// several edges does not agree at a corner, one of the triangles about it still counts.
inline constexpr float edge_slack = 0x1p-23f;

// Of a triangle, seen from the origin of a ray: for each edge the normal of the plane through it
// and the origin, for the triangle its height along its own normal.
template <typename V>
struct SeenTriangle {
  Vector3<V> edge[3];  // [opposite vertex]
  V height;
};

// Not normalised; counter-clockwise corners are seen from where it points to.
template <typename V>
OMMA_HD Vector3<V> triangle_normal(const Vector3<V> (&corner)[3]) {
  return cross(corner[1] - corner[0], corner[2] - corner[0]);
}

// `corner` relative to the origin of the ray.
template <typename V, typename N>
OMMA_HD SeenTriangle<V> see_from_origin(const Vector3<V> (&corner)[3], const Vector3<N>& normal) {
  SeenTriangle<V> seen;
  for (int i = 0; i < 3; ++i) {
    const Vector3<V>&a = corner[(i + 1) % 3], &b = corner[(i + 2) % 3];
    seen.edge[i] = cross(b + a, b - a);
  }
  seen.height = dot(corner[0], normal);
  return seen;
}

// What the rays of some lanes meet of a triangle's plane and edges.
template <typename F>
struct Crossing {
  F t_m;
  F weight[3];  // of the vertices, times `sum`
  F sum;
  F facing;  // direction times the triangle's normal: above 0 from behind
};

// A bit for each lane that passes between the edges, nearer or further away.
template <typename F, typename V>
OMMA_HD unsigned cross_triangle(const SeenTriangle<V>& seen, const Vector3<float>& normal,
                                const Vector3<F>& direction, Crossing<F>& crossing) {
  for (int i = 0; i < 3; ++i) crossing.weight[i] = dot(seen.edge[i], direction);
  const F(&w)[3] = crossing.weight;
  crossing.sum = w[0] + w[1] + w[2];
  const F slack = (crossing.sum < 0.0f ? -crossing.sum : crossing.sum) * edge_slack;
  const F lowest = least(w[0], least(w[1], w[2])), highest = most(w[0], most(w[1], w[2]));
  const unsigned bits = lane_bits(lowest >= -slack) | lane_bits(highest <= slack);
  if (bits == 0) {
    crossing.facing = crossing.t_m = broadcast<F>(0.0f);
    return 0;
  }
  crossing.facing = dot(direction, normal);
  crossing.t_m = seen.height / crossing.facing;
  return bits & ~lane_bits(crossing.facing == 0.0f);
}

// A weight as a fraction of all three.
template <typename F>
OMMA_HD F weight_fraction(const Crossing<F>& crossing, int vertex) {
  return clamp_unit_lanes(crossing.weight[vertex] / crossing.sum);
}

}  // namespace omma
