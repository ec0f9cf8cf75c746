// Into which cells the light on a scene is divided when it is baked.
#pragma once

#include <cstdint>
#include <vector>

#include "backend/clearance.h"
#include "model/scene_place.h"
#include "omma/bake.h"
#include "omma/scene.h"

namespace omma {

struct BakeCells {
  double cell_m = 0;  // the longest edge of a cell
  std::vector<std::int32_t> first_cell;                     // as in BakedLight
  std::vector<std::vector<std::int32_t>> cell_of_triangle;  // as in BakedLight
  std::int64_t cells = 0;
  std::int64_t by_probes = 0;  // triangles without a cell
};

// Bytes of a cell: both sides, all bands, of 16 bits.
inline std::size_t bytes_of_cell(std::size_t bands) {
  return 4 * bands;
}

// Of a triangle as it is placed; 0 where all its corners are in one place.
double longest_edge_m(const Scene& scene, const Placement& placement, std::size_t instance,
                      std::size_t triangle);

// Throws omma::Error where cells of a given size do not fit into memory. Without one there are some
// five times as many cells as triangles, smaller where other surfaces are near (clearances_m);
// where not even one cell for each triangle fits, instances of the smallest triangles get none.
BakeCells divide_into_cells(const Tracing& tracing, const Scene& scene, const Placement& placement,
                            std::size_t bands, const BakeSettings& settings);

}  // namespace omma
