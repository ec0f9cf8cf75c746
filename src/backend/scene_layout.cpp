// Copies or shared structures, and the transforms of both.
#include "backend/scene_layout.h"

#include <algorithm>
#include <cmath>

#include "model/scene_place.h"

namespace omma {
namespace {

// About 75 MB of acceleration structure.
constexpr std::size_t most_copied_triangles = std::size_t(1) << 20;

Mat4 moved(Mat4 t, Vec3d by) {
  t.m[0][3] += by.x, t.m[1][3] += by.y, t.m[2][3] += by.z;
  return t;
}

}  // namespace

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

void place_instance(SceneLayout& layout, std::size_t index, const Placement& placement) {
  PlacedInstance& instance = layout.instances[index];
  const auto i = static_cast<std::size_t>(instance.instance);
  Mat4 t = moved(placement.world_from_mesh[i], placement.origin_m * -1.0);
  const std::uint32_t seen_by = placement.seen_by.empty() ? all_seen : placement.seen_by[i];
  layout.placed[index] = {instance.mesh, mesh_per_world(t), instance.instance, seen_by};
  if (instance.is_shared)
    t = moved(t, transform_vector(
                     t, layout.mesh_origin_m[static_cast<std::size_t>(instance.mesh)]));
  instance.frame_from_mesh = t;
}

// Copies of small meshes trace up to three times as fast as shared structures, whose boxes overlap
// in grass and foliage; where copies would take much memory, meshes used more than once are shared.
SceneLayout lay_out_scene(const Scene& scene, const Placement& placement) {
  std::vector<int> uses(scene.meshes.size(), 0);
  for (const Instance& instance : scene.instances) ++uses[static_cast<std::size_t>(instance.mesh)];
  std::size_t copied_triangles = 0;
  for (std::size_t m = 0; m < scene.meshes.size(); ++m)
    if (uses[m] > 1)
      copied_triangles += static_cast<std::size_t>(uses[m]) * scene.meshes[m].triangles.size();
  const bool is_large = copied_triangles > most_copied_triangles;

  // A mirrored mesh is shared even when used once, as its copy would be wound the wrong way;
  // further instances then share it too. A mesh that an instance flattens cannot be shared, as the
  // transform has no inverse.
  SceneLayout layout;
  layout.mesh_origin_m.resize(scene.meshes.size());
  std::vector<bool> has_origin(scene.meshes.size(), false);
  std::vector<bool> is_built(scene.meshes.size(), false), has_mirrored(scene.meshes.size(), false);
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const auto m = static_cast<std::size_t>(instance.mesh);
    const std::size_t triangles = scene.meshes[m].triangles.size();
    if (triangles == 0) continue;
    const double det = determinant(instance.world_from_mesh);
    const bool has_inverse = std::fabs(det) > least_determinant;
    if (has_inverse && det < 0) has_mirrored[m] = true;
    const bool is_shared_unmoved = has_inverse && (has_mirrored[m] || (is_large && uses[m] > 1));
    if (!is_shared_unmoved || !is_built[m]) layout.built_triangles += triangles;
    if (is_shared_unmoved) is_built[m] = true;
    const bool moves = placement.moves[i] != 0;
    const bool is_shared = moves || is_shared_unmoved;
    if (is_shared && !has_origin[m]) {
      layout.mesh_origin_m[m] = origin_near(mesh_bounds(scene.meshes[m]));
      has_origin[m] = true;
    }
    layout.instances.push_back({static_cast<std::int32_t>(i), instance.mesh, is_shared, {}});
    if (moves) ++layout.moving;
  }
  std::stable_partition(layout.instances.begin(), layout.instances.end(),
                        [&](const PlacedInstance& placed) {
                          return placement.moves[static_cast<std::size_t>(placed.instance)] != 0;
                        });

  layout.placed.resize(std::max<std::size_t>(layout.instances.size(), 1));
  layout.index_of.assign(scene.instances.size(), -1);
  for (std::size_t k = 0; k < layout.instances.size(); ++k) {
    layout.index_of[static_cast<std::size_t>(layout.instances[k].instance)] =
        static_cast<std::int32_t>(k);
    place_instance(layout, k, placement);
  }
  return layout;
}

}  // namespace omma
