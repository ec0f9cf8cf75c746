// How an axis becomes a unit vector, the same for eyes from files and eyes from memory.
#pragma once

#include <algorithm>
#include <cmath>

#include "omma/vec.h"

namespace omma {

// The unit vector along `axis`, {0, 0, 0} for one that is zero or not finite. A vector that is
// already a unit vector as well as float can say is returned as it is, so that normalising twice,
// or saving and loading an eye, does not move the last bit.
inline Vec3 unit_axis(Vec3d axis) {
  const double largest = std::max({std::fabs(axis.x), std::fabs(axis.y), std::fabs(axis.z)});
  if (!(largest > 0) || !std::isfinite(axis.x) || !std::isfinite(axis.y) || !std::isfinite(axis.z))
    return {0, 0, 0};
  // Rounding three components to float moves the length by at most sqrt(3) * 2^-25 = 5.2e-8.
  if (std::fabs(dot(axis, axis) - 1) <= 1.2e-7) return to_float(axis);
  const Vec3d scaled{axis.x / largest, axis.y / largest, axis.z / largest};
  return to_float(normalize(scaled));
}

}  // namespace omma
