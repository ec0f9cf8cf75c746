// Transforms that are put together and taken apart, in double precision.
#pragma once

#include <array>

#include "omma/vec.h"

namespace omma {

// The inverse of an affine transform whose determinant is not 0.
Mat4 inverse(const Mat4& t);

// translation * rotation * scale, of a unit quaternion x, y, z, w.
Mat4 transform_of(const std::array<double, 3>& translation_m, const std::array<double, 4>& rotation,
                  const std::array<double, 3>& scale);

}  // namespace omma
