// Which transforms can place an eye or a camera: what the tracer computes in single precision must
// neither overflow nor vanish.
#pragma once

#include <string>

#include "omma/vec.h"

namespace omma {

// Rays may start this far from the scene (Embree takes 1.8e18 m).
inline constexpr double most_distance_m = 1e18;

// What is expected of a transform and found instead; "" where it can place an eye.
std::string pose_fault(const Mat4& pose);

// Metres of the world per metre of the head at most (the Frobenius norm, up to 1.7 times that).
double most_stretch(const Mat4& pose);

}  // namespace omma
