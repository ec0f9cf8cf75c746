// Divides triangles into cells, as many as fit into memory.
#include "backend/bake_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

#include "omma/error.h"

namespace omma {
namespace {

// So that edges of 2^10 parts and sums of cells stay in 32 bits.
constexpr double most_divisions = 1024;
constexpr std::int64_t most_cells = std::numeric_limits<std::int32_t>::max();
// Cells where their size is chosen: so many for each triangle, and besides these.
constexpr std::int64_t cells_of_triangle = 5, cells_of_small_scenes = std::int64_t{1} << 15;

// Longest edge of each triangle of each mesh, where it is placed largest: [mesh][triangle], m.
std::vector<std::vector<float>> longest_edges(const Scene& scene, const Placement& placement) {
  std::vector<std::vector<float>> edges(scene.meshes.size());
  const std::vector<bool> is_in_reach = instances_in_reach(scene, placement);
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    if (!is_in_reach[i]) continue;
    const auto m = static_cast<std::size_t>(scene.instances[i].mesh);
    const Mesh& mesh = scene.meshes[m];
    edges[m].resize(mesh.triangles.size(), 0.0f);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      edges[m][t] =
          std::max(edges[m][t], static_cast<float>(longest_edge_m(scene, placement, i, t)));
  }
  return edges;
}

// What sizes of cells depend on: the longest edges of triangles and, without a given size, their
// clearances, [mesh][triangle], m.
struct Sizes {
  std::vector<std::vector<float>> edges, clearances;
  double under_clutter = 0;  // the longest edge of a cell there, over the clearance; 0: any
};

// Clearances that count, over the edge: nearer or farther says nothing of the whole triangle.
constexpr double nearest = 1.0 / 64, farthest = 64;

// Light on a large triangle under clutter, as on ground under grass, varies over a fraction of the
// clearance, whatever the size of the triangle. This fraction bounds the cells there, if that makes
// no more cells than these; else a larger one.
constexpr double finest_under_clutter = 0.125;
constexpr std::int64_t most_under_clutter = std::int64_t{1} << 17;

double edge_under_clutter_m(const Sizes& sizes, std::size_t mesh, std::size_t triangle) {
  const auto edge_m = static_cast<double>(sizes.edges[mesh][triangle]);
  return std::max(sizes.under_clutter *
                      std::max<double>(sizes.clearances[mesh][triangle], nearest * edge_m),
                  edge_m / most_divisions);
}

// Into how many pieces a triangle's edge is divided. With a given size: so that no cell is longer.
// Else cells are the smaller the closer other surfaces are, and the larger the larger the triangle:
// ground far away has large ones. In the lit meadow, at equally many cells, green light was nearer
// to that of paths with these exponents than with twice the exponent of the clearance.
std::int64_t divisions(const Sizes& sizes, std::size_t mesh, std::size_t triangle, double cell_m) {
  const auto edge_m = static_cast<double>(sizes.edges[mesh][triangle]);
  if (!(edge_m > 0)) return 1;  // all its corners in one place
  double own_m = cell_m;
  if (!sizes.clearances.empty()) {
    const double clearance_m =
        std::clamp<double>(sizes.clearances[mesh][triangle], nearest * edge_m, farthest * edge_m);
    own_m = std::sqrt(edge_m * std::sqrt(cell_m * clearance_m));
    if (sizes.under_clutter > 0)
      own_m = std::min(own_m, edge_under_clutter_m(sizes, mesh, triangle));
  }
  return static_cast<std::int64_t>(std::clamp(std::ceil(edge_m / own_m), 1.0, most_divisions));
}

std::int64_t cells_of_mesh(const Sizes& sizes, std::size_t mesh, double cell_m) {
  std::int64_t cells = 0;
  for (std::size_t t = 0; t < sizes.edges[mesh].size(); ++t) {
    const std::int64_t k = divisions(sizes, mesh, t, cell_m);
    cells += k * k;
  }
  return cells;
}

struct Counted {
  const Scene& scene;
  const Sizes& sizes;
  std::vector<bool> has_cells;  // [instance]

  std::int64_t cells(double cell_m) const {
    std::vector<std::int64_t> of_mesh(sizes.edges.size(), -1);
    std::int64_t all = 0;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
      if (!has_cells[i]) continue;
      const auto m = static_cast<std::size_t>(scene.instances[i].mesh);
      if (of_mesh[m] < 0) of_mesh[m] = cells_of_mesh(sizes, m, cell_m);
      all += of_mesh[m];
    }
    return all;
  }
};

// Cells that triangles would have for their clearances alone, but for those that need no division.
std::int64_t cells_under_clutter(const Counted& counted) {
  const Sizes& sizes = counted.sizes;
  std::int64_t all = 0;
  for (std::size_t i = 0; i < counted.scene.instances.size(); ++i) {
    if (!counted.has_cells[i]) continue;
    const auto m = static_cast<std::size_t>(counted.scene.instances[i].mesh);
    for (std::size_t t = 0; t < sizes.edges[m].size(); ++t) {
      const auto k = static_cast<std::int64_t>(std::ceil(
          static_cast<double>(sizes.edges[m][t]) / edge_under_clutter_m(sizes, m, t)));
      if (k > 1) all += k * k;
    }
  }
  return all;
}

// The finest division by clearances, within a twentieth, of at most so many cells. `counted` refers to
// `sizes`.
void choose_under_clutter(const Counted& counted, Sizes& sizes, std::int64_t most) {
  double fine = finest_under_clutter, coarse = 1 / nearest;  // which divides nothing
  sizes.under_clutter = fine;
  if (cells_under_clutter(counted) <= most) return;
  while (coarse > 1.05 * fine) {
    sizes.under_clutter = std::sqrt(fine * coarse);
    (cells_under_clutter(counted) <= most ? coarse : fine) = sizes.under_clutter;
  }
  sizes.under_clutter = coarse;
}

// The smallest cells, within a hundredth, of which there are at most so many.
double smallest_cell_m(const Counted& counted, std::int64_t most) {
  double large = 0;
  for (const std::vector<float>& edges : counted.sizes.edges)
    for (const float edge : edges) large = std::max(large, static_cast<double>(edge));
  if (!(large > 0)) return 1;
  double small = large / (counted.sizes.clearances.empty() ? most_divisions : 1e12);
  if (counted.cells(small) <= most) return small;
  while (large > small * 1.01) {
    const double middle = std::sqrt(small * large);
    (counted.cells(middle) <= most ? large : small) = middle;
  }
  return large;
}

std::string in_mebibytes(double bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g MiB", bytes / 1048576);
  return text;
}

// Removes the cells of instances, those with the smallest triangles first, until the rest fits.
void leave_out_smallest(Counted& counted, std::int64_t room) {
  const Scene& scene = counted.scene;
  const auto triangles = [&](std::size_t i) {
    return static_cast<std::int64_t>(
        counted.sizes.edges[static_cast<std::size_t>(scene.instances[i].mesh)].size());
  };
  const auto mean_edge = [&](std::size_t i) {
    const std::vector<float>& edges = counted.sizes.edges[static_cast<std::size_t>(scene.instances[i].mesh)];
    return std::accumulate(edges.begin(), edges.end(), 0.0) /
           std::max<double>(1, static_cast<double>(edges.size()));
  };
  std::vector<std::pair<double, std::size_t>> order;
  std::int64_t all = 0;
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    if (!counted.has_cells[i]) continue;
    order.emplace_back(mean_edge(i), i);
    all += triangles(i);
  }
  std::sort(order.begin(), order.end());
  for (const auto& [edge, i] : order) {
    if (all <= room) return;
    counted.has_cells[i] = false;
    all -= triangles(i);
  }
}

}  // namespace

double longest_edge_m(const Scene& scene, const Placement& placement, std::size_t instance,
                      std::size_t triangle) {
  const auto m = static_cast<std::size_t>(scene.instances[instance].mesh);
  const std::vector<Vec3>& positions = positions_of(scene, placement, m);
  const auto& vertex = scene.meshes[m].triangles[triangle];
  double longest_m = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3d edge = to_double(positions[vertex[(k + 1) % 3]]) - to_double(positions[vertex[k]]);
    longest_m =
        std::max(longest_m, length(transform_vector(placement.world_from_mesh[instance], edge)));
  }
  return longest_m;
}

BakeCells divide_into_cells(const Tracing& tracing, const Scene& scene, const Placement& placement,
                            std::size_t bands, const BakeSettings& settings) {
  Sizes sizes{longest_edges(scene, placement), {}};
  if (!(settings.cell_m > 0)) sizes.clearances = clearances_m(tracing, scene, placement);
  const std::vector<std::vector<float>>& edges = sizes.edges;
  Counted counted{scene, sizes, instances_in_reach(scene, placement)};
  const auto room = static_cast<std::int64_t>(std::min<std::size_t>(
      settings.most_bytes / bytes_of_cell(bands), static_cast<std::size_t>(most_cells)));
  BakeCells plan;
  double cell_m = 0;
  std::int64_t triangles = 0;
  for (std::size_t i = 0; i < scene.instances.size(); ++i)
    if (counted.has_cells[i])
      triangles += static_cast<std::int64_t>(edges[static_cast<std::size_t>(scene.instances[i].mesh)].size());
  if (settings.cell_m > 0) {
    cell_m = settings.cell_m;
    const std::int64_t needed = counted.cells(settings.cell_m);
    if (needed > room) {
      const double each = static_cast<double>(bytes_of_cell(bands));
      char fits[64];
      if (triangles <= room)
        std::snprintf(fits, sizeof fits, "cells of %.3g m would fit",
                      smallest_cell_m(counted, room));
      else
        std::snprintf(fits, sizeof fits, "not even one for each triangle fits");
      throw Error("baked light: expected cells in " +
                  in_mebibytes(static_cast<double>(settings.most_bytes)) + ", found " +
                  std::to_string(needed) + " cells, which take " +
                  in_mebibytes(static_cast<double>(needed) * each) + "; " + fits);
    }
  } else {
    if (triangles > room) leave_out_smallest(counted, room);
    const std::int64_t most = std::min(most_under_clutter, (room - triangles) / 2);
    choose_under_clutter(counted, sizes, std::max<std::int64_t>(most, 0));
    cell_m = smallest_cell_m(counted,
                             std::min(room, cells_of_triangle * triangles + cells_of_small_scenes +
                                                cells_under_clutter(counted)));
  }

  const std::vector<bool> is_in_reach = instances_in_reach(scene, placement);
  plan.cell_of_triangle.resize(edges.size());
  std::vector<std::int64_t> of_mesh(edges.size(), 0);
  std::vector<bool> is_divided(edges.size(), false);
  for (std::size_t i = 0; i < scene.instances.size(); ++i)
    if (counted.has_cells[i]) is_divided[static_cast<std::size_t>(scene.instances[i].mesh)] = true;
  for (std::size_t m = 0; m < edges.size(); ++m) {
    if (!is_divided[m]) continue;
    std::vector<std::int32_t> first{0};
    for (std::size_t t = 0; t < edges[m].size(); ++t) {
      const std::int64_t k = divisions(sizes, m, t, cell_m);
      plan.cell_m =
          std::max(plan.cell_m, static_cast<double>(edges[m][t]) / static_cast<double>(k));
      of_mesh[m] += k * k;
      first.push_back(static_cast<std::int32_t>(of_mesh[m]));
    }
    if (of_mesh[m] > static_cast<std::int64_t>(edges[m].size()))
      plan.cell_of_triangle[m] = std::move(first);
  }
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const auto m = static_cast<std::size_t>(scene.instances[i].mesh);
    const auto own = static_cast<std::int64_t>(edges[m].size());
    const bool has_cells = counted.has_cells[i] && own > 0;
    plan.first_cell.push_back(has_cells ? static_cast<std::int32_t>(plan.cells) : -1);
    if (has_cells)
      plan.cells += of_mesh[m];
    else if (is_in_reach[i])
      plan.by_probes += own;
  }
  return plan;
}

}  // namespace omma
