// What ommatidia aim at, as the physics sees it (block/aims_in_view.h). Made by backend/light_aims.
#pragma once

#include <cstdint>

#include "omma/vec.h"

namespace omma {

// Something small and bright that ommatidia aim at: a piece of a surface that shines, or a disc as
// a plane mirror shows it, or as it is seen through a volume.
struct AimView {
  // Of a piece its middle in the mesh of `instance`, m; of a mirror two directions in its plane.
  Vec3 centre, across;
  float radius_m = 0;          // of a piece, where the instance's largest scale is 1
  float chord_2 = 0;           // of an image's rim, as of DiscView
  std::int32_t instance = -1;  // of the scene; -1: a disc itself
  std::int32_t disc = -1;      // of LightView; -1: a piece
  float brightest = 0;         // bound on its mean radiance, of the brightest band
};

// As many as AimsInView has bits for.
inline constexpr std::int32_t most_aims = 1024;

}  // namespace omma
