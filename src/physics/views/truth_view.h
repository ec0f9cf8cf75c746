// What is asked of the ground truth beside radiance (truth_sums.h), and where it goes.
#pragma once

#include <cstdint>

namespace omma {

// What is asked, and of which instances of the scene.
struct TruthView {
  bool places = false;                               // positions and normals
  bool flow = false;                                 // optic flow
  bool sources = false;                              // how far away light comes from
  int shares = 0;                                    // groups whose shares are counted
  const std::int32_t* share_of_instance = nullptr;   // [instance], its group, or -1
  const std::int32_t* object_of_instance = nullptr;  // [instance], among what moves, or -1; or null
  std::int32_t instance_count = 0;                   // of both tables, which are never empty
  std::int32_t object_count = 0;
};

// Where the ground truth of one pose goes (omma/truth.h says what it is); each may be null. And the
// motions there: of the head, of objects about the origins of their frames.
struct TruthTask {
  double origin_m[3] = {};  // of the traced frame, in the world
  float linear_m_s[3] = {}, angular_rad_s[3] = {};
  const float* objects = nullptr;  // [object][origin in the traced frame, linear, angular][3]
  float *distance_m = nullptr, *nearest_m = nullptr, *inverse_distance_per_m = nullptr;
  float *met = nullptr, *normal = nullptr, *shares = nullptr;
  double* position_m = nullptr;
  float* source_distance_m = nullptr;
  float *flow_rotation = nullptr, *flow_translation = nullptr, *flow_objects = nullptr;
};

}  // namespace omma
