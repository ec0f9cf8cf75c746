// Where a scene lies in the world. It is traced in single precision, so the numbers that count are
// distances from an origin near it, found here in double; and what is lost all the same is told.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "model/new_version.h"
#include "omma/scene.h"

namespace omma {

// Half an interval between floats, as a fraction of the number: what rounding to single precision
// changes at most.
inline constexpr double float_rounding = 0x1p-24;

// Surfaces may lie this far away: beyond, Embree's products of coordinates leave single precision.
inline constexpr double most_geometry_m = 1e12;

// Instanced meshes need the inverse of their transform in single precision: determinants whose
// magnitude is less, or more than one over it, have none there.
inline constexpr double least_determinant = 1e-30;

// Corners of the box around vertices; and around those of a mesh, in its own frame, empty without
// triangles.
Bounds vertex_bounds(const std::vector<Vec3>& positions);
Bounds mesh_bounds(const Mesh& mesh);

// Corners of a box around all instances and splats; not the tightest where they are turned or have
// vertices that no triangle uses, but found without placing every vertex.
Bounds rough_scene_bounds(const Scene& scene);

// Half the longest side of a box, m.
double half_size_m(const Bounds& box);

// The point to trace from what lies in a box: the origin itself unless that lies far from the box
// compared with its size, else one within it. Numbers in it have few digits, so that subtracting it
// changes no vertex.
Vec3d origin_near(const Bounds& box);

// Corners of the boxes around a box under a transform, and around two boxes.
Bounds placed_box(const Bounds& box, const Mat4& transform);
Bounds box_around(const Bounds& a, const Bounds& b);

// Whether what lies in a box is too far from an origin to be traced.
bool is_too_far(const Bounds& box, Vec3d from);

// Boxes of the meshes that are placed somewhere, [mesh], in their own frames; else empty.
std::vector<Bounds> boxes_of_used_meshes(const Scene& scene);

// Vertices of a mesh that has changed its shape, as omma::Mesh has them.
struct Shape {
  std::vector<Vec3> positions;  // [vertex], m
  std::vector<Vec3> normals;    // [vertex], where the mesh has them
  Version version = new_version();
};

// Where the instances of a scene are, which of them have been moved and which rays meet those, what
// shape its meshes have, and what all are traced from.
struct Placement {
  std::vector<Mat4> world_from_mesh;  // [instance]
  std::vector<char> moves;            // [instance]; those of a mesh that changes its shape do
  std::vector<std::uint32_t> seen_by;  // [instance], PlacedMesh::seen_by; empty: by all
  std::vector<Shape> shapes;          // [mesh], with positions where it has changed
  Vec3d origin_m;                     // of the traced frame, in the world
  double half_size_m = 0;             // of the box around all, its longest side
};

// Nothing has been moved.
Placement placement_of(const Scene& scene);

// [instance], whether rays may meet it: not one that is too far from what all are traced from.
std::vector<bool> instances_in_reach(const Scene& scene, const Placement& placement);

// The vertices of a mesh as it is now, m.
inline const std::vector<Vec3>& positions_of(const Scene& scene, const Placement& placement,
                                             std::size_t mesh) {
  const std::vector<Vec3>& changed = placement.shapes[mesh].positions;
  return changed.empty() ? scene.meshes[mesh].positions : changed;
}

// What single precision does to a scene: vertices that it has rounded, instances too far away to be
// seen. A sentence each; `who` says what has vertices in single precision.
std::vector<std::string> place_warnings(const Scene& scene,
                                        const std::string& who = "meshes are kept");

}  // namespace omma
