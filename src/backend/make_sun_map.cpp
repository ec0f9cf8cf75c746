// Traces the sun's shadow map; sun_map_grid.cpp chooses its pages.
#include "backend/make_sun_map.h"

#include <algorithm>
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

constexpr std::size_t packets_of_launch = 4096;  // some megabytes

// Texels of a packet are a square.
constexpr std::int32_t packet_side = 4;
static_assert(packet_side * packet_side == packet_rays);

// Where rays start, of a page's first texel and from one texel to the next, in the traced frame.
struct SunRays {
  Vec3d first, per_column, per_row;
  Vec3 direction;  // unit, away from the sun
};

std::int32_t packets_along(std::int32_t texels) {
  return (texels + packet_side - 1) / packet_side;
}

// A page's rays, [packet row][packet column]; those beyond the last texel repeat it.
void set_rays(const SunRays& rays, std::int32_t columns, std::int32_t rows,
              RayPacket<packet_rays>* packet) {
  for (std::int32_t row = 0; row < rows; row += packet_side)
    for (std::int32_t column = 0; column < columns; column += packet_side, ++packet) {
      clear<Lanes<packet_rays, 1>>(*packet);
      for (std::int32_t l = 0; l < packet_rays; ++l) {
        const std::int32_t i = std::min(column + l % packet_side, columns - 1);
        const std::int32_t j = std::min(row + l / packet_side, rows - 1);
        const Vec3 origin = to_float(rays.first + rays.per_column * i + rays.per_row * j);
        store_vector(packet->origin, l, vector_of(origin));
        store_vector(packet->direction, l, vector_of(rays.direction));
        packet->t_near_m[l] = 0;
        packet->t_far_m[l] = INFINITY;
      }
    }
}

// How far they went until they met something, [row][column], m; infinite where they did not.
std::vector<float> distances_m(const RayPacket<packet_rays>* packets, std::int32_t columns,
                               std::int32_t rows) {
  std::vector<float> distance_m;
  distance_m.reserve(static_cast<std::size_t>(columns * rows));
  for (std::int32_t row = 0; row < rows; ++row)
    for (std::int32_t column = 0; column < columns; ++column) {
      const RayPacket<packet_rays>& packet =
          packets[row / packet_side * packets_along(columns) + column / packet_side];
      const std::int32_t l = row % packet_side * packet_side + column % packet_side;
      distance_m.push_back(packet.geometry[l] == none ? INFINITY : packet.t_far_m[l]);
    }
  return distance_m;
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
  const auto side_of = [&](std::size_t p) { return std::int32_t{1} << grid.level[p]; };
  const auto columns_of = [&](std::size_t p) { return side_of(p) * sun_tile_columns + 1; };
  const auto rows_of = [&](std::size_t p) { return side_of(p) * sun_tile_rows + 1; };
  const auto packets_of = [&](std::size_t p) {
    return static_cast<std::size_t>(packets_along(columns_of(p)) * packets_along(rows_of(p)));
  };
  std::vector<RayPacket<packet_rays>> packets;
  std::vector<std::size_t> first_packet;  // of the pages of a launch
  for (std::size_t first = 0, last = 0; first < map.pages.size(); first = last) {
    first_packet.assign(1, 0);
    do first_packet.push_back(first_packet.back() + packets_of(last++));
    while (last < map.pages.size() && first_packet.back() < packets_of_launch);
    packets.resize(first_packet.back());
    parallel_for(first, last, [&](std::size_t p) {
      const auto page_column = static_cast<double>(p % static_cast<std::size_t>(grid.columns));
      const auto page_row = static_cast<double>(p / static_cast<std::size_t>(grid.columns));
      const double texel_m = grid.page_texel_m / side_of(p);
      SunPage& page = map.pages[p];
      page.tile_and_level =
          (static_cast<std::int32_t>(first_tile[p]) << sun_level_bits) | grid.level[p];
      page.texel_m = static_cast<float>(texel_m);
      const SunRays rays{
          frame.axis[0] * (grid.first_m[0] + page_column * sun_tile_columns * grid.page_texel_m) +
              frame.axis[1] * (grid.first_m[1] + page_row * sun_tile_rows * grid.page_texel_m) +
              frame.axis[2] * top_m,
          frame.axis[0] * texel_m, frame.axis[1] * texel_m, direction};
      set_rays(rays, columns_of(p), rows_of(p), packets.data() + first_packet[p - first]);
    });
    tracing.closest(packets, tracing.tracer);
    parallel_for(first, last, [&](std::size_t p) {
      const std::vector<float> distance_m =
          distances_m(packets.data() + first_packet[p - first], columns_of(p), rows_of(p));
      put_heights(distance_m.data(), side_of(p), top_m, map.pages[p],
                  map.tiles.data() + first_tile[p]);
    });
    work.reach(static_cast<double>(first_tile[last]) / static_cast<double>(map.tiles.size()));
  }

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
