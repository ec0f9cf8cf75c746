// Gives memory to pages by their density of triangles: the width of a page's texels is a share of
// the mean width of its triangles, the same share for all pages, the smallest that fits.
#include "backend/sun_map_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/light/sun_map.h"
#include "threads/cancel.h"

namespace omma {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Texels where they are not asked for: 5 mm, and at least so many along a small scene.
constexpr double usual_texel_m = 0.005;
constexpr double least_texels = 2000;

// Pages grow to the greatest level until there are enough_pages or fewer, then their number grows
// to most_pages, then texels become coarser. Columns and rows are bounded so that a position in
// single precision is exact to a twentieth of the finest texel.
constexpr double enough_pages = 4096, most_pages = 65536;
constexpr double most_columns = 512, most_rows = 1024;
constexpr int most_level = 7;

// Of the memory, what pages of level 0 may take.
constexpr double share_of_coarsest = 0.125;

// A cut-out has edges besides those of its triangles.
constexpr double triangles_of_cut_out = 16;

// Words are counted in 31 bits.
constexpr double most_tiles = 0x1p27 - 1;
constexpr double tile_bytes = 4 * sun_tile_words;

Vec3d corner_of(const Bounds& box, int corner) {
  return {corner & 1 ? box.upper.x : box.lower.x, corner & 2 ? box.upper.y : box.lower.y,
          corner & 4 ? box.upper.z : box.lower.z};
}

// A rectangle across the light.
struct Extent {
  double lower_m[2] = {infinity, infinity}, upper_m[2] = {-infinity, -infinity};

  void include(const SunFrame& frame, Vec3d p) {
    for (int a = 0; a < 2; ++a) {
      const double x = dot(p, frame.axis[a]);
      lower_m[a] = std::min(lower_m[a], x);
      upper_m[a] = std::max(upper_m[a], x);
    }
  }
};

// Calls body(instance, box of its mesh) for all that are near enough to be traced.
template <typename Body>
void for_each_placed(const Scene& scene, const Placement& placement, const Body& body) {
  std::vector<Bounds> boxes = boxes_of_used_meshes(scene);
  for (std::size_t m = 0; m < boxes.size(); ++m)
    if (!boxes[m].empty && !placement.shapes[m].positions.empty())
      boxes[m] = vertex_bounds(placement.shapes[m].positions);
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Bounds& box = boxes[static_cast<std::size_t>(scene.instances[i].mesh)];
    if (box.empty || is_too_far(placed_box(box, placement.world_from_mesh[i]), placement.origin_m))
      continue;
    check_cancelled();
    body(i, box);
  }
}

// How many triangles lie at each page; one counts at all that its rectangle overlaps.
class Detail {
 public:
  explicit Detail(const SunGrid& grid)
      : grid_(grid), counts_(std::size_t(grid.columns + 1) * std::size_t(grid.rows + 1)) {}

  double page_m(int axis) const {
    return (axis == 0 ? sun_tile_columns : sun_tile_rows) * grid_.page_texel_m;
  }

  void add(const Extent& extent, double triangles) {
    const auto page_of = [&](int a, double x, std::int32_t count) {
      const double page = std::floor((x - grid_.first_m[a]) / page_m(a));
      return static_cast<std::int32_t>(std::clamp(page, 0.0, count - 1.0));
    };
    const std::int32_t c0 = page_of(0, extent.lower_m[0], grid_.columns);
    const std::int32_t c1 = page_of(0, extent.upper_m[0], grid_.columns) + 1;
    const std::int32_t r0 = page_of(1, extent.lower_m[1], grid_.rows);
    const std::int32_t r1 = page_of(1, extent.upper_m[1], grid_.rows) + 1;
    at(c0, r0) += triangles;
    at(c1, r0) -= triangles;
    at(c0, r1) -= triangles;
    at(c1, r1) += triangles;
  }

  // [page], once. What was added are differences, so that a triangle costs the same however large.
  std::vector<double> sums() {
    std::vector<double> sums;
    for (std::int32_t r = 0; r < grid_.rows; ++r)
      for (std::int32_t c = 0; c < grid_.columns; ++c) {
        if (c > 0) at(c, r) += at(c - 1, r);
        sums.push_back(at(c, r) + (r > 0 ? sums[sums.size() - std::size_t(grid_.columns)] : 0));
      }
    return sums;
  }

 private:
  double& at(std::int32_t column, std::int32_t row) {
    return counts_[std::size_t(row) * std::size_t(grid_.columns + 1) + std::size_t(column)];
  }

  const SunGrid& grid_;
  std::vector<double> counts_;
};

std::vector<double> count_triangles(const Scene& scene, const Placement& placement,
                                    const SunFrame& frame, const SunGrid& grid) {
  Detail detail(grid);
  for_each_placed(scene, placement, [&](std::size_t i, const Bounds& box) {
    const Mesh& mesh = scene.meshes[static_cast<std::size_t>(scene.instances[i].mesh)];
    const std::vector<Vec3>& positions =
        positions_of(scene, placement, static_cast<std::size_t>(scene.instances[i].mesh));
    const auto place = [&](Vec3d p) {
      return transform_point(placement.world_from_mesh[i], p) - placement.origin_m;
    };
    const bool is_cut_out =
        mesh.material >= 0 &&
        scene.materials[static_cast<std::size_t>(mesh.material)].alpha_mode == AlphaMode::mask;
    const double each = is_cut_out ? triangles_of_cut_out : 1;
    Extent of_all;
    for (int corner = 0; corner < 8; ++corner) of_all.include(frame, place(corner_of(box, corner)));
    bool is_small = true;
    for (int a = 0; a < 2; ++a)
      is_small = is_small && of_all.upper_m[a] - of_all.lower_m[a] <= detail.page_m(a);
    if (is_small) return detail.add(of_all, each * static_cast<double>(mesh.triangles.size()));
    for (const auto& triangle : mesh.triangles) {
      Extent extent;
      for (const std::uint32_t vertex : triangle)
        extent.include(frame, place(to_double(positions[vertex])));
      detail.add(extent, each);
    }
  });
  return detail.sums();
}

// The level at which texels are `share` times as wide as the page's triangles, if each covers an
// equal area of it.
int level_of(double triangles, double share, int finest) {
  if (!(triangles > 0)) return 0;
  const double texels = double{sun_tile_columns} * double{sun_tile_rows};  // at level 0
  const double wanted = std::ceil(0.5 * std::log2(triangles / texels) - std::log2(share));
  return static_cast<int>(std::clamp(wanted, 0.0, static_cast<double>(finest)));
}

}  // namespace

SunFrame sun_frame_around(const Scene& scene, const Placement& placement, Vec3d towards) {
  SunFrame frame;
  const Vec3d other = std::fabs(towards.y) < 0.9 ? Vec3d{0, 1, 0} : Vec3d{1, 0, 0};
  frame.axis[0] = normalize(cross(other, towards));
  frame.axis[1] = cross(towards, frame.axis[0]);
  frame.axis[2] = towards;
  bool is_empty = true;
  for_each_placed(scene, placement, [&](std::size_t i, const Bounds& box) {
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d p = transform_point(placement.world_from_mesh[i], corner_of(box, corner)) -
                      placement.origin_m;
      for (int a = 0; a < 3; ++a) {
        const double x = dot(p, frame.axis[a]);
        frame.lower_m[a] = is_empty ? x : std::min(frame.lower_m[a], x);
        frame.upper_m[a] = is_empty ? x : std::max(frame.upper_m[a], x);
      }
      frame.reach_m = std::max(frame.reach_m, length(p));
      is_empty = false;
    }
  });
  return frame;
}

SunGrid choose_sun_grid(const Scene& scene, const Placement& placement, const SunFrame& frame,
                        double texel_m, std::size_t most_bytes) {
  const double extent_m[2] = {frame.upper_m[0] - frame.lower_m[0],
                              frame.upper_m[1] - frame.lower_m[1]};
  const double longest_m = std::max(extent_m[0], extent_m[1]);
  if (!(texel_m > 0)) {
    texel_m = usual_texel_m;
    if (longest_m > 0) texel_m = std::min(texel_m, longest_m / least_texels);
  }
  // A margin of a fine texel before the scene and of a coarse one behind it: at the rim nothing is
  // met.
  SunGrid grid;
  const double bytes = static_cast<double>(most_bytes);
  const double affordable =
      std::max(1.0, std::floor(share_of_coarsest * bytes / (tile_bytes + sizeof(SunPage))));
  int finest = 0;
  double columns = 1, rows = 1;
  for (;;) {
    grid.page_texel_m = std::ldexp(texel_m, finest);
    const auto pages = [&](int axis, double side) {
      return std::ceil((extent_m[axis] + texel_m + grid.page_texel_m) / (side * grid.page_texel_m));
    };
    columns = pages(0, sun_tile_columns);
    rows = pages(1, sun_tile_rows);
    const double most = std::min(finest < most_level ? enough_pages : most_pages, affordable);
    if (columns * rows <= most && columns <= most_columns && rows <= most_rows) break;
    if (finest < most_level)
      ++finest;
    else
      texel_m *= 1.25;
  }
  grid.columns = static_cast<std::int32_t>(columns);
  grid.rows = static_cast<std::int32_t>(rows);
  for (int a = 0; a < 2; ++a) grid.first_m[a] = frame.lower_m[a] - texel_m;

  const std::vector<double> triangles = count_triangles(scene, placement, frame, grid);
  const double tiles =
      std::min((bytes - columns * rows * sizeof(SunPage)) / tile_bytes, most_tiles);
  // Shares grow by less than a level at a time, so that not all pages change level at once; the
  // first makes pages as fine as they can be, the last as coarse.
  double share = 0x1p-10;
  for (; share < 0x1p40; share *= 1.1) {
    double taken = 0;
    for (const double count : triangles)
      taken += std::ldexp(1.0, 2 * level_of(count, share, finest));
    if (taken <= tiles) break;
  }
  grid.coarsest_texel_m = grid.finest_texel_m = 0;
  for (const double count : triangles) {
    const int level = level_of(count, share, finest);
    grid.level.push_back(static_cast<std::uint8_t>(level));
    if (!(count > 0)) continue;
    const double texel = std::ldexp(grid.page_texel_m, -level);
    grid.finest_texel_m = grid.finest_texel_m > 0 ? std::min(grid.finest_texel_m, texel) : texel;
    grid.coarsest_texel_m = std::max(grid.coarsest_texel_m, texel);
  }
  return grid;
}

}  // namespace omma
