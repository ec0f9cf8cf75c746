// Ground truth beside radiance: what the rays of each ommatidium met, weighted as radiance is. Of
// layers that let light through the first surface met counts; cut-outs are as they are seen. Of
// Gaussian splats a ray meets the one before and in which half of its light is.
#pragma once

#include <cstdint>
#include <span>

#include "omma/vec.h"

namespace omma {

// How a frame moves, in the world's frame: the velocity of its origin, and the angular velocity
// about that, right-handed about the vector.
struct Velocity {
  Vec3d linear_m_s;
  Vec3d angular_rad_s;
};

// Most groups of instances whose shares are told, and most objects that move, in one call.
inline constexpr int most_shares = 1 << 14;

// What is asked for: where there is room for it. Means are over the rays, and so over the
// ommatidium's angular sensitivity. Empty for none.
struct TruthCall {
  // [pose, ommatidium], of where rays start, along the ray, m: the mean over what was met, and the
  // nearest; infinite where nothing was. The mean of its inverse counts 0 where nothing was met.
  std::span<float> distance_m = {};
  std::span<float> nearest_m = {};
  std::span<float> inverse_distance_per_m = {};
  // Of all that light comes from, weighted by how much does: in worlds without Gaussian splats the
  // same as distance_m, which among splats is where half of a ray's light comes from before.
  std::span<float> source_distance_m = {};
  std::span<float> met = {};  // [pose, ommatidium], share of the field in which anything was met
  // [pose, ommatidium, axis] in the world: means over what was met, not a number where nothing was.
  // Normals are those of triangles, of unit length and towards the eye, before the mean.
  std::span<double> position_m = {};
  std::span<float> normal = {};
  // Shares of the field, [pose, ommatidium, group], and the group of each of World::instances and
  // of each cloud of splats behind them, -1 for none.
  std::span<float> shares = {};
  std::span<const std::int32_t> share_of_instance = {};  // [instance of the world]
  int share_count = 0;

  // Optic flow: the angular velocity of what is seen, [pose, ommatidium, (right, up)], rad/s, in
  // the up and right of the ommatidium, turned with it from its axis to the ray by the shortest
  // turn. With a ray's direction d and the distance r (Koenderink and van Doorn 1987):
  std::span<float> flow_rotation = {};        // -w x d, from the head's angular velocity w
  std::span<float> flow_translation = {};     // -(t - (t d) d) / r, t that of where the ray starts
  std::span<float> flow_objects = {};         // (v - (v d) d) / r, v that of the surface
  std::span<const Velocity> head = {};        // [pose], of the head's frame; empty: at rest
  std::span<const std::int32_t> moving = {};  // [object], indices into World::instances
  std::span<const Velocity> objects = {};     // [pose, object], of their nodes' frames
};

}  // namespace omma
