// The rays of a picture, laid out for tracing: what render_camera makes of a camera and a world
// keeps for its next picture.
#pragma once

#include <vector>

#include "backend/eye_arrays.h"
#include "omma/camera.h"
#include "sampling/directions.h"

namespace omma {

// Rays in bands of pixels, [pixel][sample] within each.
struct CameraRays {
  Camera lens;  // its kind and numbers; where it is plays no part
  CameraSettings settings;
  std::size_t pixels_per_band = 1;
  DirectionTables directions;  // of single rays, the same for all bands
  // [band], or fewer: the last ones are laid out each time where all would be too many.
  std::vector<EyeArrays> bands;

  std::size_t pixels() const {
    return static_cast<std::size_t>(settings.size.width) *
           static_cast<std::size_t>(settings.size.height);
  }
  std::size_t band_count() const { return (pixels() + pixels_per_band - 1) / pixels_per_band; }
};

}  // namespace omma
