// How a Scene is laid out for tracing: the frame it is traced in, which instances are put into the
// world directly, as copies of their mesh, and which keep their mesh in a structure that is shared.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "omma/scene.h"
#include "physics/ray_packet.h"

namespace omma {

// An instance whose mesh has triangles.
struct PlacedInstance {
  std::int32_t instance = 0;  // index into Scene::instances
  std::int32_t mesh = 0;
  bool is_shared = false;  // its mesh's structure is instanced; else its triangles are copied
  // Traced frame from the mesh's own; where it is shared, from the mesh about mesh_origin_m.
  Mat4 frame_from_mesh;
};

struct Placement {
  Vec3d origin_m;          // of the traced frame, in the world
  double half_size_m = 0;  // of the box around the scene, its longest side
  std::vector<PlacedInstance> instances;
  std::vector<PlacedMesh> placed;    // [instance], in the same order
  std::vector<Vec3d> mesh_origin_m;  // [mesh], where it is shared: the point it is kept about
};

// Whether a mesh with that transform can be shared: a flattened one has no inverse.
bool can_be_shared(const Mat4& world_from_mesh);

// `world_from_mesh` [instance of the scene] is where they are now. `is_moving` [the same]: not 0
// for those that move, which are shared whatever their size, where they can be.
Placement place_instances(const Scene& scene, std::span<const Mat4> world_from_mesh,
                          std::span<const std::uint8_t> is_moving);

// Moves an instance: only its transform changes, and what follows from it.
void place_instance(const Placement& placement, const Mat4& world_from_mesh,
                    PlacedInstance& instance, PlacedMesh& placed);

}  // namespace omma
