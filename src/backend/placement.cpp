// Copies or shared structures, and the transforms of both.
#include "backend/placement.h"

#include <algorithm>
#include <cmath>

#include "model/scene_place.h"

namespace omma {
namespace {

// Shared structures need the inverse of the transform in single precision, where that of a smaller
// determinant would underflow.
constexpr double least_determinant = 1e-30;

// About 75 MB of acceleration structure.
constexpr std::size_t most_copied_triangles = std::size_t(1) << 20;

Mat4 moved(Mat4 t, Vec3d by) {
  t.m[0][3] += by.x, t.m[1][3] += by.y, t.m[2][3] += by.z;
  return t;
}

// Metres of a mesh per metre of the world, along the direction that its transform stretches most:
// one over the largest singular value of A, whose square is the largest eigenvalue of B = A^T A
// (closed form of a symmetric 3x3: O. K. Smith 1961, doi:10.1145/355578.366316).
float mesh_per_world(const Mat4& world_from_mesh) {
  double b[3][3] = {};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) b[i][j] += world_from_mesh.m[k][i] * world_from_mesh.m[k][j];
  const double mean = (b[0][0] + b[1][1] + b[2][2]) / 3;
  for (int i = 0; i < 3; ++i) b[i][i] -= mean;
  double squares = 0;
  for (const auto& row : b)
    for (const double value : row) squares += value * value;
  const double spread = std::sqrt(squares / 6);
  const double det = b[0][0] * (b[1][1] * b[2][2] - b[1][2] * b[2][1]) -
                     b[0][1] * (b[1][0] * b[2][2] - b[1][2] * b[2][0]) +
                     b[0][2] * (b[1][0] * b[2][1] - b[1][1] * b[2][0]);
  const double cosine =
      spread > 0 ? std::clamp(det / (2 * spread * spread * spread), -1.0, 1.0) : 1.0;
  const double largest = mean + 2 * spread * std::cos(std::acos(cosine) / 3);
  return largest > 0 ? static_cast<float>(1 / std::sqrt(largest)) : 0.0f;
}

}  // namespace

bool can_be_shared(const Mat4& world_from_mesh) {
  return std::fabs(determinant(world_from_mesh)) > least_determinant;
}

void place_instance(const Placement& placement, const Mat4& world_from_mesh,
                    PlacedInstance& instance, PlacedMesh& placed) {
  Mat4 t = moved(world_from_mesh, placement.origin_m * -1.0);
  placed = {instance.mesh, mesh_per_world(t)};
  if (instance.is_shared)
    t = moved(
        t, transform_vector(t, placement.mesh_origin_m[static_cast<std::size_t>(instance.mesh)]));
  instance.frame_from_mesh = t;
}

// Copies of small meshes trace up to three times as fast as shared structures, whose boxes overlap
// in grass and foliage; where copies would take much memory, meshes used more than once are shared.
Placement place_instances(const Scene& scene, std::span<const Mat4> world_from_mesh,
                          std::span<const std::uint8_t> is_moving) {
  std::vector<int> uses(scene.meshes.size(), 0);
  for (const Instance& instance : scene.instances) ++uses[static_cast<std::size_t>(instance.mesh)];
  std::size_t copied_triangles = 0;
  for (std::size_t m = 0; m < scene.meshes.size(); ++m)
    if (uses[m] > 1)
      copied_triangles += static_cast<std::size_t>(uses[m]) * scene.meshes[m].triangles.size();
  const bool is_large = copied_triangles > most_copied_triangles;

  Placement placement;
  const Bounds box = rough_scene_bounds(scene);
  placement.origin_m = origin_near(box);
  placement.half_size_m = half_size_m(box);
  placement.mesh_origin_m.resize(scene.meshes.size());
  std::vector<bool> has_origin(scene.meshes.size(), false),
      has_mirrored(scene.meshes.size(), false);
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const auto m = static_cast<std::size_t>(instance.mesh);
    if (scene.meshes[m].triangles.empty()) continue;
    // A mirrored mesh is shared even when used once: as a copy its triangles would face the wrong
    // way; its structure is then there for the instances behind it. A flattened one never is: there
    // is no inverse.
    const Mat4& t = world_from_mesh[i];
    const bool can_be = can_be_shared(t);
    if (can_be && determinant(t) < 0) has_mirrored[m] = true;
    const bool is_shared =
        can_be && (has_mirrored[m] || is_moving[i] != 0 || (is_large && uses[m] > 1));
    if (is_shared && !has_origin[m]) {
      placement.mesh_origin_m[m] = origin_near(mesh_bounds(scene.meshes[m]));
      has_origin[m] = true;
    }
    placement.instances.push_back({static_cast<std::int32_t>(i), instance.mesh, is_shared, {}});
    placement.placed.emplace_back();
    place_instance(placement, t, placement.instances.back(), placement.placed.back());
  }
  return placement;
}

}  // namespace omma
