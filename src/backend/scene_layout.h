// How a Scene is laid out for tracing, the same for every backend: which instances are put into the
// world directly, as copies of their mesh, and which keep their mesh in a structure that is shared.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/scene_place.h"
#include "omma/scene.h"
#include "physics/views/ray_packet.h"

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
  // Those that have been moved come first, otherwise in the Scene's order.
  std::vector<PlacedInstance> instances;
  std::size_t moving = 0;  // how many of them have been moved
  // [instance], in the same order. Never empty: packets look up entry 0 for lanes that missed.
  std::vector<PlacedMesh> placed{PlacedMesh{}};
  std::vector<std::int32_t> index_of;  // [instance of the Scene], here; -1 of those without triangles
  std::vector<Vec3d> mesh_origin_m;    // [mesh], where it is shared: the point it is kept about
  // Of all copies and of each shared mesh once, as they would be if nothing had been moved.
  std::size_t built_triangles = 0;
};

// Of all instances as they are placed. Those that have been moved are shared whatever their size,
// and those that have not are laid out as if none had been.
SceneLayout lay_out_scene(const Scene& scene, const Placement& placement);

// Puts an instance (index into `instances`) where it is placed now: only its transform changes, and
// what follows from it.
void place_instance(SceneLayout& layout, std::size_t index, const Placement& placement);

}  // namespace omma
