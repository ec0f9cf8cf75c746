// Traces the sun's shadow map; sun_map_grid.cpp chooses its pages.
#include "backend/make_sun_map.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "backend/sun_map_grid.h"
#include "threads/parallel.h"

namespace omma {
namespace {

// Depth bias, so that surfaces do not shadow themselves: a fraction of a texel, for concave edges
// between triangles, plus a fraction of the largest coordinate, for rounding. A larger bias lets
// light pass beneath blades of grass; with a tenth of a texel both errors cancel, and the lit
// meadow is as bright by its map as by shadow rays (bench/baked_error.py).
constexpr double bias_texels = 0.1;
constexpr double bias_of_reach = 0x1p-20;

constexpr std::int32_t most_code = 0xffff;

// Texels of a packet are a square.
constexpr std::int32_t packet_side = 4;
static_assert(packet_side * packet_side == packet_rays);

// Where rays start, of a page's first texel and from one texel to the next, in the traced frame.
struct SunRays {
  Vec3d first, per_column, per_row;
  Vec3 direction;  // unit, away from the sun
};

// How far rays go until they meet something, [row][column], m; infinite where they do not.
void trace_texels(const Tracing& tracing, const SunRays& rays, std::int32_t columns,
                  std::int32_t rows, float* distance_m) {
  RayPacket<packet_rays> packet{};
  for (std::int32_t row = 0; row < rows; row += packet_side) {
    check_cancelled();
    for (std::int32_t column = 0; column < columns; column += packet_side) {
      clear<Lanes<packet_rays, 1>>(packet);
      LaneMask<Lanes<packet_rays, 1>> inside;
      for (std::int32_t l = 0; l < packet_rays; ++l) {
        const std::int32_t i = column + l % packet_side, j = row + l / packet_side;
        if (i < columns && j < rows) inside.add(l);
        const Vec3 origin = to_float(rays.first + rays.per_column * i + rays.per_row * j);
        packet.origin[0][l] = origin.x;
        packet.origin[1][l] = origin.y;
        packet.origin[2][l] = origin.z;
        packet.direction[0][l] = rays.direction.x;
        packet.direction[1][l] = rays.direction.y;
        packet.direction[2][l] = rays.direction.z;
        packet.t_near_m[l] = 0;
        packet.t_far_m[l] = INFINITY;
      }
      tracing.closest(tracing.tracer, inside.bits, packet);
      inside.for_each([&](std::int32_t l) {
        distance_m[(row + l / packet_side) * columns + column + l % packet_side] =
            packet.geometry[l] == none ? INFINITY : packet.t_far_m[l];
      });
    }
  }
}

// Quantises heights to the page's own range and writes them into its tiles; rounded down, so that
// no surface is above itself. `top_m`: the height at which rays start.
void put_heights(const float* distance_m, std::int32_t side, double top_m, SunPage& page,
                 SunTile* tiles) {
  const std::int32_t columns = side * sun_tile_columns + 1, rows = side * sun_tile_rows + 1;
  float nearest = INFINITY, farthest = -INFINITY;
  for (std::int32_t k = 0; k < columns * rows; ++k) {
    if (!(distance_m[k] < INFINITY)) continue;
    nearest = std::min(nearest, distance_m[k]);
    farthest = std::max(farthest, distance_m[k]);
  }
  if (nearest > farthest) return;
  const double range_m = std::max<double>(page.texel_m, double{farthest} - double{nearest});
  page.lowest_m = static_cast<float>(top_m - double{farthest});
  page.codes_per_m = static_cast<float>((most_code - 2) / range_m);
  const auto code_at = [&](std::int32_t column, std::int32_t row) {
    const float distance = distance_m[row * columns + column];
    if (!(distance < INFINITY)) return 0;
    const double above_m = top_m - double{distance} - double{page.lowest_m};
    const double code = std::floor(above_m * double{page.codes_per_m}) + 1;
    return static_cast<std::int32_t>(std::clamp(code, 1.0, double{most_code}));
  };
  for (std::int32_t tile = 0; tile < side * side; ++tile)
    for (std::int32_t word = 0; word < sun_tile_words; ++word) {
      const std::int32_t row = tile / side * sun_tile_rows + word / sun_row_words;
      const std::int32_t column = tile % side * sun_tile_columns + word % sun_row_words * 2;
      tiles[tile].words[word] =
          int_of(uint_of(code_at(column, row)) | uint_of(code_at(column + 1, row)) << 16);
    }
}

void set_axis(float (&axis)[3], Vec3d v) {
  const Vec3 rounded = to_float(v);
  axis[0] = rounded.x, axis[1] = rounded.y, axis[2] = rounded.z;
}

}  // namespace

SunMapData make_sun_map(const Tracing& tracing, const Scene& scene, const Placement& placement,
                        Vec3 towards, const SunMapSettings& settings, const WorkPart& work) {
  const SunFrame frame = sun_frame_around(scene, placement, normalize(to_double(towards)));
  const SunGrid grid =
      choose_sun_grid(scene, placement, frame, settings.texel_m, settings.most_bytes);
  SunMapData map;
  map.pages.resize(grid.level.size());
  std::vector<std::size_t> first_tile(grid.level.size() + 1);
  for (std::size_t p = 0; p < grid.level.size(); ++p)
    first_tile[p + 1] = first_tile[p] + (std::size_t{1} << 2 * grid.level[p]);
  map.tiles.resize(first_tile.back());
  map.finest_texel_m = grid.finest_texel_m;
  map.coarsest_texel_m = grid.coarsest_texel_m;

  const double above_m = grid.page_texel_m;
  const double top_m = frame.upper_m[2] + above_m;
  const Vec3 away = to_float(frame.axis[2] * -1.0);
  const Vec3 direction{without_noise(away.x), without_noise(away.y), without_noise(away.z)};
  std::atomic<std::size_t> tiles_done{0};
  parallel_for(std::size_t{0}, map.pages.size(), [&](std::size_t p) {
    const std::int32_t level = grid.level[p], side = 1 << level;
    const auto page_column = static_cast<double>(p % static_cast<std::size_t>(grid.columns));
    const auto page_row = static_cast<double>(p / static_cast<std::size_t>(grid.columns));
    const double texel_m = grid.page_texel_m / side;
    SunPage& page = map.pages[p];
    page.tile_and_level = (static_cast<std::int32_t>(first_tile[p]) << sun_level_bits) | level;
    page.texel_m = static_cast<float>(texel_m);
    const SunRays rays{
        frame.axis[0] * (grid.first_m[0] + page_column * sun_tile_columns * grid.page_texel_m) +
            frame.axis[1] * (grid.first_m[1] + page_row * sun_tile_rows * grid.page_texel_m) +
            frame.axis[2] * top_m,
        frame.axis[0] * texel_m, frame.axis[1] * texel_m, direction};
    const std::int32_t columns = side * sun_tile_columns + 1, rows = side * sun_tile_rows + 1;
    std::vector<float> distance_m(static_cast<std::size_t>(columns * rows));
    trace_texels(tracing, rays, columns, rows, distance_m.data());
    put_heights(distance_m.data(), side, top_m, page, map.tiles.data() + first_tile[p]);
    const std::size_t of_page = first_tile[p + 1] - first_tile[p];
    const std::size_t done = tiles_done += of_page;
    work.reach(static_cast<double>(done) / static_cast<double>(map.tiles.size()));
  });

  SunMapView& view = map.view;
  view.pages = map.pages.data();
  view.words = map.tiles.front().words;
  view.page_columns = grid.columns;
  view.page_rows = grid.rows;
  view.tile_count = static_cast<std::int32_t>(map.tiles.size());
  view.last_column = std::nextafter(static_cast<float>(grid.columns), 0.0f);
  view.last_row = std::nextafter(static_cast<float>(grid.rows), 0.0f);
  set_axis(view.column_axis, frame.axis[0]);
  set_axis(view.row_axis, frame.axis[1]);
  set_axis(view.towards, frame.axis[2]);
  const double column_per_m = 1 / (sun_tile_columns * grid.page_texel_m);
  const double row_per_m = 1 / (sun_tile_rows * grid.page_texel_m);
  view.column_per_m = static_cast<float>(column_per_m);
  view.row_per_m = static_cast<float>(row_per_m);
  view.column_offset = static_cast<float>(-grid.first_m[0] * column_per_m);
  view.row_offset = static_cast<float>(-grid.first_m[1] * row_per_m);
  view.bias_m = static_cast<float>(bias_of_reach * (frame.reach_m + above_m));
  view.bias_texels = static_cast<float>(bias_texels);
  return map;
}

}  // namespace omma
