// How a Scene is laid out for tracing: which instances are put into the world directly, as copies of their mesh, and which keep their mesh in a structure that is shared.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/scene_place.h"
#include "omma/scene.h"
#include "physics/ray_packet.h"

namespace omma {

// Metres of a mesh per metre of the world, along the direction that its transform stretches most:
// one over the largest singular value of A, whose square is the largest eigenvalue of B = A^T A
// (closed form of a symmetric 3x3: O. K. Smith 1961, doi:10.1145/355578.366316).
float mesh_per_world(const Mat4& world_from_mesh);

// An instance whose mesh has triangles.
struct PlacedInstance {
  std::int32_t instance = 0;  // index into Scene::instances
  std::int32_t mesh = 0;
  bool is_shared = false;  // its mesh's structure is instanced; else its triangles are copied
  // Traced frame from the mesh's own; where it is shared, from the mesh about mesh_origin_m.
  Mat4 frame_from_mesh;
};

struct SceneLayout {
  std::vector<PlacedInstance> instances;
  std::vector<PlacedMesh> placed;    // [instance], in the same order
  std::vector<Vec3d> mesh_origin_m;  // [mesh], where it is shared: the point it is kept about
};

// Of all instances as they are placed; those that have been moved are shared whatever their size.
SceneLayout lay_out_scene(const Scene& scene, const Placement& placement);

// Puts an instance where it is placed now: only its transform changes, and what follows from it.
void place_instance(SceneLayout& layout, std::size_t index, const Placement& placement);

}  // namespace omma
