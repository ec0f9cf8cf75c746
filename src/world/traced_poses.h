// Poses on their way into a render: copied, checked together with the eye, and moved to the origin
// that the scene is traced from.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "backend/eye_arrays.h"
#include "omma/scene.h"
#include "omma/vec.h"

namespace omma {

// The poses relative to `origin_m` (world), copied before they are checked, so that a caller who
// changes his while a render runs changes nothing. Throws omma::Error that names the pose where one
// cannot place an eye, or rays of this eye would start further away than can be traced.
std::vector<Mat4> traced_poses(std::span<const Mat4> world_from_head, const EyeArrays& eye,
                               Vec3d origin_m);

// Single precision places rays and surfaces less and less exactly with their distance from that
// origin: a sentence that names the worst pose and what is lost there, in a scene of that half
// size; "" where it does not matter.
std::string precision_warning(std::span<const Mat4> world_from_head, Vec3d origin_m,
                              double half_size_m);

// As World::pose_slip, in a scene of that size about that origin.
std::string pose_slip(std::span<const Mat4> world_from_head, Vec3d origin_m, double half_size_m,
                      const std::vector<Camera>& cameras);

}  // namespace omma
