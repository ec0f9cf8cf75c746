// Cells of baked light, found among the triangles of a scene.
#include "backend/bake_owners.h"

#include <algorithm>

#include "backend/bake_cells.h"
#include "physics/path/baked.h"

namespace omma {

CellOwners::CellOwners(const BakedLight& baked, const Scene& scene) : baked_(baked), scene_(scene) {
  for (std::size_t i = 0; i < baked.first_cell.size(); ++i)
    if (baked.first_cell[i] >= 0) first_.emplace_back(baked.first_cell[i], i);
}

CellOwner CellOwners::operator()(std::int32_t cell) const {
  const auto after = std::upper_bound(
      first_.begin(), first_.end(), cell,
      [](std::int32_t value, const auto& entry) { return value < entry.first; });
  CellOwner owner;
  owner.instance = std::prev(after)->second;
  const std::int32_t left = cell - std::prev(after)->first;
  const auto mesh = static_cast<std::size_t>(scene_.instances[owner.instance].mesh);
  const std::vector<std::int32_t>& cells = baked_.cell_of_triangle[mesh];
  owner.triangle = left;
  if (cells.empty()) return owner;
  const auto next = std::upper_bound(cells.begin(), cells.end(), left);
  owner.triangle = static_cast<std::int32_t>(next - cells.begin()) - 1;
  owner.within = left - *std::prev(next);
  owner.count = *next - *std::prev(next);
  return owner;
}

BakedSides baked_sides(const SceneView& view, std::int32_t mesh) {
  const std::int32_t material = view.meshes[mesh].material;
  const bool through = view.scatter[material].transmittance != nullptr;
  return {true, view.materials[material].double_sided || through};
}

CellShape shape_of(const Scene& scene, const Placement& placement, const CellOwner& owner) {
  const auto m = static_cast<std::size_t>(scene.instances[owner.instance].mesh);
  const std::vector<Vec3>& positions = positions_of(scene, placement, m);
  const auto& vertex = scene.meshes[m].triangles[static_cast<std::size_t>(owner.triangle)];
  const Mat4& placed = placement.world_from_mesh[owner.instance];
  Vec3d corner[3];
  for (std::size_t c = 0; c < 3; ++c)
    corner[c] = transform_point(placed, to_double(positions[vertex[c]])) - placement.origin_m;
  const std::int32_t k = divisions_of(owner.count);
  float uv[3][2];
  corners_of_cell(k, owner.within, uv);
  const Vec3d e1 = corner[1] - corner[0], e2 = corner[2] - corner[0];
  CellShape shape;
  shape.middle = corner[0];
  for (const auto& of_corner : uv)
    shape.middle = shape.middle + (e1 * double{of_corner[0]} + e2 * double{of_corner[1]}) * (1.0 / 3);
  shape.edge_m = longest_edge_m(scene, placement, owner.instance,
                                static_cast<std::size_t>(owner.triangle)) / k;
  const Vec3d area = cross(e1, e2);
  if (dot(area, area) > 0) shape.normal = normalize(area);
  return shape;
}

}  // namespace omma
