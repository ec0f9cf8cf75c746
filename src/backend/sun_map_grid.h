// The pages of the sun's shadow map, and how fine each is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/scene_place.h"
#include "omma/scene.h"

namespace omma {

// Axes across the light and, third, towards the sun; and what of them the scene takes.
struct SunFrame {
  Vec3d axis[3];  // unit, right-handed
  double lower_m[3] = {}, upper_m[3] = {};
  double reach_m = 0;  // the greatest distance of what is there from the traced frame's origin
};

// `towards`: unit.
SunFrame sun_frame_around(const Scene& scene, const Placement& placement, Vec3d towards);

struct SunGrid {
  std::int32_t columns = 1, rows = 1;  // of pages
  double first_m[2] = {};              // of the first texel of the first page, in the frame
  double page_texel_m = 0;             // a page of level 0 has texels of this size, level 1 of half
  std::vector<std::uint8_t> level;     // [page]
  double finest_texel_m = 0, coarsest_texel_m = 0;  // of pages that have triangles
};

// Of texels of this size or coarser (0: it is chosen), so that all take at most so many bytes.
SunGrid choose_sun_grid(const Scene& scene, const Placement& placement, const SunFrame& frame,
                        double texel_m, std::size_t most_bytes);

}  // namespace omma
