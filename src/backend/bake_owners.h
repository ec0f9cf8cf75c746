// Which triangle of which instance a cell of baked light belongs to, and where it lies.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "model/scene_place.h"
#include "omma/bake.h"
#include "omma/scene.h"
#include "physics/views/scene_view.h"

namespace omma {

struct CellOwner {
  std::size_t instance = 0;
  std::int32_t triangle = 0, within = 0, count = 1;  // its number within the triangle, of how many
};

// Refers to both.
class CellOwners {
 public:
  CellOwners(const BakedLight& baked, const Scene& scene);
  CellOwner operator()(std::int32_t cell) const;

 private:
  const BakedLight& baked_;
  const Scene& scene_;
  std::vector<std::pair<std::int32_t, std::size_t>> first_;  // cell, instance; where cells begin
};

// Which of a mesh's sides are ever looked up.
struct BakedSides {
  bool front = true, back = true;
};

BakedSides baked_sides(const SceneView& view, std::int32_t mesh);

// A cell in the traced frame: its middle, m, its longest edge, m, and the normal of its front, unit;
// zero where it has no area.
struct CellShape {
  Vec3d middle, normal;
  double edge_m = 0;
};

CellShape shape_of(const Scene& scene, const Placement& placement, const CellOwner& owner);

}  // namespace omma
