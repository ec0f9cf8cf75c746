// Trees over lights, as the physics sees them (physics/light/light_tree.h). Made by
// backend/light_tree_data.
#pragma once

#include <cmath>
#include <cstdint>

#include "omma/vec.h"

namespace omma {

// Of lights as one.
struct LightNode {
  Vec3 lower, upper;      // m, of the box around them
  float variance_m2 = 0;  // of their places, by power
  float power = 0;        // falls with the square of the distance
  float steady = 0;       // does not: of directional lamps
  // Where those whose light falls with distance send none: farther from the box than range_m, and
  // beyond a cone about `axis`, which is a unit vector; a cosine of -1: all around.
  float range_m = INFINITY;
  Vec3 axis;
  float cos_reach = -1;
};

// A binary tree over lights (physics/light/light_tree.h), complete, in the order of a heap: those
// below node k are 2 k + 1 and 2 k + 2, and each has half of the node's ranks. Of some ranks there
// is no light.
struct LightTreeView {
  const LightNode* nodes = nullptr;  // [2 leaves - 1]
  const std::int32_t* light_of_rank = nullptr;  // [rank]
  const std::int32_t* rank_of_light = nullptr;  // [light], as long as the other
  const float* sum = nullptr;  // [rank + 1], cumulative probabilities where no place is known
  std::int32_t leaves = 1, count = 0;  // powers of two; of ranks
  std::int32_t lights = 0;
};

}  // namespace omma
