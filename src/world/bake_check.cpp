// Whether baked light is whole, and that of a scene.
#include <cmath>
#include <string>

#include "omma/bake.h"
#include "omma/error.h"
#include "physics/path/baked.h"

namespace omma {

void check_baked_light(const BakedLight& baked, const Scene& scene, int expected_bands) {
  const auto fail = [](const std::string& what) { throw Error("baked light: expected " + what); };
  const auto bands = static_cast<std::size_t>(baked.bands);
  if (baked.bands != expected_bands)
    fail(std::to_string(expected_bands) + " bands, as the world has, found " +
         std::to_string(baked.bands));
  if (!(baked.unit > 0) || !std::isfinite(baked.unit)) fail("a unit above 0");
  if (baked.first_cell.size() != scene.instances.size() ||
      baked.cell_of_triangle.size() != scene.meshes.size())
    fail(std::to_string(scene.instances.size()) + " instances of " +
         std::to_string(scene.meshes.size()) + " meshes, as the scene has, found " +
         std::to_string(baked.first_cell.size()) + " of " +
         std::to_string(baked.cell_of_triangle.size()));
  if (baked.cells < 0 ||
      baked.lines.size() * (sizeof(BakedLine) / 2) < 2 * bands * static_cast<std::size_t>(baked.cells))
    fail("values of all its " + std::to_string(baked.cells) + " cells");
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const std::vector<std::int32_t>& first = baked.cell_of_triangle[m];
    if (first.empty()) continue;
    if (first.size() != scene.meshes[m].triangles.size() + 1 || first.front() != 0)
      fail("the cells of each triangle of meshes[" + std::to_string(m) + "]");
    for (std::size_t t = 0; t + 1 < first.size(); ++t) {
      const std::int64_t count = std::int64_t{first[t + 1]} - first[t];
      if (count < 1 || count != std::int64_t{divisions_of(first[t + 1] - first[t])} *
                                    divisions_of(first[t + 1] - first[t]))
        fail("a square number of cells of each triangle of meshes[" + std::to_string(m) + "]");
    }
  }
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    if (baked.first_cell[i] < 0) continue;
    const auto m = static_cast<std::size_t>(scene.instances[i].mesh);
    const std::vector<std::int32_t>& first = baked.cell_of_triangle[m];
    const std::int64_t count = first.empty()
                                   ? static_cast<std::int64_t>(scene.meshes[m].triangles.size())
                                   : first.back();
    if (baked.first_cell[i] + count > baked.cells)
      fail("cells of instances[" + std::to_string(i) + "] among its " + std::to_string(baked.cells));
  }
  std::size_t probes = 1;
  for (int a = 0; a < 3; ++a) {
    if (baked.probes[a] < 2 || baked.probes[a] > 65536 || !(baked.probe_spacing_m[a] > 0) ||
        !std::isfinite(baked.probe_spacing_m[a]) || !std::isfinite(baked.probe_origin_m[a]))
      fail("two probes or more along each side");
    probes *= static_cast<std::size_t>(baked.probes[a]);
  }
  if (baked.probe_values.size() != 6 * bands * probes) fail("values of all its probes");
}

}  // namespace omma
