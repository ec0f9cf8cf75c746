// The shape of a mesh that is blended between morph targets and bent by bones.
#pragma once

#include "model/animation.h"
#include "model/scene_place.h"

namespace omma {

// Vertices of a deformation with the rig in a pose. Runs on the threads of the arena it is called in.
Shape eval_shape(const Rig& rig, const Deformation& deformation, const RigPose& pose);

// Normals of vertices: of the triangles around each the mean, weighed by their area. A vertex that
// no triangle with an area has keeps the one in `otherwise`.
std::vector<Vec3> normals_of(const std::vector<Vec3>& positions,
                             const std::vector<std::array<std::uint32_t, 3>>& triangles,
                             const std::vector<Vec3>& otherwise);

}  // namespace omma
