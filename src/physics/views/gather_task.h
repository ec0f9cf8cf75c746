// What light is baked for, as the physics sees it: patches of surfaces and probes in the air. Made
// by world/bake_gather, gathered by physics/path/gather.h.
#pragma once

#include <cstdint>

#include "physics/views/scene_view.h"

namespace omma {

// What light is gathered for: a side of a patch of a cell, or a direction of a probe in the air.
struct Receiver {
  // A patch of a triangle, on one side: its corners [corner][u, v]. mesh -1: in the air.
  std::int32_t instance = -1, mesh = -1, triangle = 0;
  bool is_back = false;
  float uv[3][2] = {};
  float reach_m = 0;      // of a patch: what is nearer hides points from eyes
  Vec3 position, normal;  // in the air, traced frame
  std::uint32_t hash = 0;
};

struct GatherTask {
  const Receiver* receivers = nullptr;
  int count = 0;  // of receivers; more than one only where a packet holds all their paths
  int paths = 0;  // of each
  // Whose light surfaces that shine are sampled from: of a scene without baked light, which leaves
  // them out.
  const SceneView* shining = nullptr;
  double* mean = nullptr;  // over the paths of each receiver, [receiver][band], in the view's unit
};

}  // namespace omma
