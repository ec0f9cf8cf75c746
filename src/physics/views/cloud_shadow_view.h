// Shadows of clouds, as the physics sees them (light/cloud_shadow.h).
#pragma once

#include <cstdint>

namespace omma {

// omma::CloudShadow, as places are given to lamps.
struct CloudShadowView {
  const float* optical_depth = nullptr;  // [row][column]; null: none
  std::int32_t columns = 0, rows = 0;
  float height_m = 0;
  float per_m = 0;                        // nodes
  float first_column = 0, first_row = 0;  // of the origin
};

}  // namespace omma
