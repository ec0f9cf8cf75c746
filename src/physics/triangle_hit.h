// Where rays meet triangles, watertight along shared edges: a ray passes each edge on one side or
// the other, told by the sign of a number (Pluecker coordinates: Platis, Theoharis 2003,
// doi:10.1080/10867651.2003.10487584) that is exactly the opposite for the triangle on the other
// side, whatever the rounding: it is made of sums and differences of the edge's two corners alone.
// Nothing is fused (-ffp-contract=off).
#pragma once

#include "physics/search_lanes.h"
#include "physics/vector3.h"

namespace omma {

// A ray is inside where no weight is below minus that fraction of their sum: where the rounding of
// several edges does not agree at a corner, one of the triangles about it still counts.
inline constexpr float edge_slack = 0x1p-23f;

// Of a triangle, seen from the origin of a ray: for each edge the normal of the plane through it
// and the origin, for the triangle its height along its own normal.
template <typename V>
struct SeenTriangle {
  V edge[3][3];  // [opposite vertex][axis]
  V height;
};

// Not normalised; counter-clockwise corners are seen from where it points to.
template <typename V>
OMMA_HD void triangle_normal(const V (&corner)[3][3], V (&normal)[3]) {
  V first[3], second[3];
  for (int a = 0; a < 3; ++a) {
    first[a] = corner[1][a] - corner[0][a];
    second[a] = corner[2][a] - corner[0][a];
  }
  cross_lanes(first, second, normal);
}

// `corner` relative to the origin of the ray.
template <typename V, typename N>
OMMA_HD void see_triangle(const V (&corner)[3][3], const N (&normal)[3], SeenTriangle<V>& seen) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    V sum[3], difference[3];
    for (int a = 0; a < 3; ++a) {
      sum[a] = corner[k][a] + corner[j][a];
      difference[a] = corner[k][a] - corner[j][a];
    }
    cross_lanes(sum, difference, seen.edge[i]);
  }
  seen.height = corner[0][0] * normal[0] + corner[0][1] * normal[1] + corner[0][2] * normal[2];
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
OMMA_HD unsigned cross_triangle(const SeenTriangle<V>& seen, const float (&normal)[3],
                                const F (&direction)[3], Crossing<F>& crossing) {
  for (int i = 0; i < 3; ++i)
    crossing.weight[i] = seen.edge[i][0] * direction[0] + seen.edge[i][1] * direction[1] +
                         seen.edge[i][2] * direction[2];
  const F(&w)[3] = crossing.weight;
  crossing.sum = w[0] + w[1] + w[2];
  const F slack = (crossing.sum < 0.0f ? -crossing.sum : crossing.sum) * edge_slack;
  const F lowest = least(w[0], least(w[1], w[2])), highest = most(w[0], most(w[1], w[2]));
  const unsigned bits = lane_bits(lowest >= -slack) | lane_bits(highest <= slack);
  if (bits == 0) return 0;
  crossing.facing = direction[0] * normal[0] + direction[1] * normal[1] + direction[2] * normal[2];
  crossing.t_m = seen.height / crossing.facing;
  return bits & ~lane_bits(crossing.facing == 0.0f);
}

// A weight as a fraction of all three.
template <typename F>
OMMA_HD F weight_fraction(const Crossing<F>& crossing, int vertex) {
  return clamp_unit_lanes(crossing.weight[vertex] / crossing.sum);
}

}  // namespace omma
