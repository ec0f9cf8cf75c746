// Poses `world_from_head`: where the head is and where it looks. The head looks along its -Z, its
// +X is its right, +Y up.
#pragma once

#include "omma/vec.h"

namespace omma {

// From a position (m) and a unit quaternion (x, y, z, w); the quaternion is normalised.
Mat4 pose_from_quaternion(Vec3d position_m, double x, double y, double z, double w);

// Looking from a position towards a target, `up` roughly up; throws omma::Error where the target
// is the position or up is along the view.
Mat4 look_at(Vec3d position_m, Vec3d target_m, Vec3d up = {0, 1, 0});

}  // namespace omma
