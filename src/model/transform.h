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

// The turn of a transform as a unit quaternion x, y, z, w; what it stretches, skews and mirrors is
// the transform behind that turn.
std::array<double, 4> turn_of(const Mat4& t);

// From one unit quaternion to another, on the shorter way round.
std::array<double, 4> slerp(const double* from, const double* to, double part);

}  // namespace omma
