// Binary trees over lights (physics/light/light_tree.h): made once, and placed anew when lights
// move.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "omma/scene.h"
#include "physics/views/light_tree_view.h"

namespace omma {

// A light of a tree, or several close to each other.
struct TreeLight {
  Bounds box;  // m
  Vec3d centre_m;
  double variance_m2 = 0;  // of places on it about its centre
  double weight = 0;       // what it sends to places at the same distance, any unit
  bool is_steady = false;  // it sends that to any distance, as directional lamps do
  double range_m = std::numeric_limits<double>::infinity();  // it sends nothing farther
  Vec3d axis{};           // unit, of a cone outside of which it sends nothing
  double reach_rad = pi;  // from the axis to the edge of the cone; pi: it sends all around
};

// A lamp, or what is as small.
TreeLight tree_light(Vec3d place_m, double weight, bool is_steady = false);

// Owns what its view points to.
struct LightTree {
  std::vector<LightNode> nodes;
  // More than there are lights: -1 where there is none.
  std::vector<std::int32_t> light_of_rank, rank_of_light;
  std::vector<float> sum;
  double distance_m = 1;  // at which weights are
  std::size_t lights = 0;
  TreeLight all;          // its lights as one

  LightTreeView view() const;
};

// `distance_m`: at which the weights of all lights are meant.
LightTree make_light_tree(const std::vector<TreeLight>& lights, double distance_m = 1);

// The same lights are elsewhere; addresses stay.
void place_lights(LightTree& tree, const std::vector<TreeLight>& lights);

}  // namespace omma
