// Squares of texels, and their search.
#include "backend/alpha_blocks.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "physics/surface/texture.h"
#include "threads/parallel.h"

namespace omma {
namespace {

constexpr int squares_a_side = 4;  // of a level, that make one of the next
constexpr double infinity = std::numeric_limits<double>::infinity();

// Reading a texture that is repeated more often than this within a triangle, along one axis, may
// meet any texel of it.
constexpr double most_repeats_searched = 4;

// Triangles of no more texels a side are searched texel by texel from the start.
constexpr int most_squares = 4;

float texel_alpha(const TextureView& texture, int x, int y) {
  const float unit = texture.linear == nullptr ? 1.0f / 65535.0f : 1.0f;
  return load_texel<float>(texture, y * texture.width + x).a * unit;
}

int blocks_across(int texels) {
  return (texels + squares_a_side - 1) / squares_a_side;
}

template <typename Read>
AlphaBlocks::Level make_level(int finer_width, int finer_height, const Read& read) {
  AlphaBlocks::Level level{blocks_across(finer_width), blocks_across(finer_height), {}};
  level.ranges.resize(static_cast<std::size_t>(level.width) *
                      static_cast<std::size_t>(level.height));
  parallel_for(0, level.height, [&](int row) {
    for (int column = 0; column < level.width; ++column) {
      AlphaRange range{std::numeric_limits<float>::infinity(),
                       -std::numeric_limits<float>::infinity()};
      for (int y = row * squares_a_side; y < std::min((row + 1) * squares_a_side, finer_height);
           ++y)
        for (int x = column * squares_a_side;
             x < std::min((column + 1) * squares_a_side, finer_width); ++x) {
          const AlphaRange finer = read(x, y);
          range.least = std::min(range.least, finer.least);
          range.most = std::max(range.most, finer.most);
        }
      level.ranges[static_cast<std::size_t>(row) * static_cast<std::size_t>(level.width) +
                   static_cast<std::size_t>(column)] = range;
    }
  });
  return level;
}

AlphaRange range_at(const AlphaBlocks::Level& level, int x, int y) {
  return level.ranges[static_cast<std::size_t>(y) * static_cast<std::size_t>(level.width) +
                      static_cast<std::size_t>(x)];
}

// One repeat of the image, and the triangle as it lies to it.
struct Search {
  const AlphaBlocks& blocks;
  const AlphaLimits& limits;
  double x[3] = {}, y[3] = {};
  double reach_x = 0, reach_y = 0;            // a texel counts as far beyond its edges
  double normal_x[3] = {}, normal_y[3] = {};  // of the side from corner k to the next, outwards
  double lower_x = 0, upper_x = 0, lower_y = 0, upper_y = 0;
  bool opaque = false, transparent = false, doubtful = false;  // what was met

  bool is_over() const { return doubtful || (opaque && transparent); }
};

void prepare(Search& s) {
  s.lower_x = std::min({s.x[0], s.x[1], s.x[2]});
  s.upper_x = std::max({s.x[0], s.x[1], s.x[2]});
  s.lower_y = std::min({s.y[0], s.y[1], s.y[2]});
  s.upper_y = std::max({s.y[0], s.y[1], s.y[2]});
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3, third = (k + 2) % 3;
    const double nx = s.y[next] - s.y[k], ny = s.x[k] - s.x[next];
    const bool inwards = nx * (s.x[third] - s.x[k]) + ny * (s.y[third] - s.y[k]) > 0;
    s.normal_x[k] = inwards ? -nx : nx;
    s.normal_y[k] = inwards ? -ny : ny;
  }
}

// Whether triangle and box overlap: separating axis test, with the axes of the box and the normals
// of the triangle's sides.
bool touches(const Search& s, double left, double top, double right, double bottom) {
  const double ax = std::max(left, s.lower_x), bx = std::min(right, s.upper_x);
  const double ay = std::max(top, s.lower_y), by = std::min(bottom, s.upper_y);
  if (ax > bx || ay > by) return false;
  for (int k = 0; k < 3; ++k) {
    const double px = s.normal_x[k] > 0 ? ax : bx, py = s.normal_y[k] > 0 ? ay : by;
    if (s.normal_x[k] * (px - s.x[k]) + s.normal_y[k] * (py - s.y[k]) > 0) return false;
  }
  return true;
}

// Whether a read in the triangle may meet texels x0 to x1 - 1, y0 to y1 - 1.
bool overlaps(const Search& s, int x0, int y0, int x1, int y1) {
  const TextureView& t = s.blocks.texture;
  // Beyond the edge of a clamped image lies nothing but its last texels.
  const bool clamp_x = t.wrap_u == Wrap::clamp_to_edge, clamp_y = t.wrap_v == Wrap::clamp_to_edge;
  return touches(s, clamp_x && x0 == 0 ? -infinity : x0 - s.reach_x,
                 clamp_y && y0 == 0 ? -infinity : y0 - s.reach_y,
                 clamp_x && x1 == t.width ? infinity : x1 + s.reach_x,
                 clamp_y && y1 == t.height ? infinity : y1 + s.reach_y);
}

// Level -1 is that of the texels themselves. `x0` to `y1`: the texels to search, the last included.
void search(Search& s, int level, int x0, int y0, int x1, int y1) {
  int size = 1;
  for (int l = 0; l <= level; ++l) size *= squares_a_side;
  const TextureView& t = s.blocks.texture;
  for (int j = y0 / size; j <= y1 / size; ++j)
    for (int i = x0 / size; i <= x1 / size; ++i) {
      AlphaRange range;
      if (level >= 0)
        range = range_at(s.blocks.levels[static_cast<std::size_t>(level)], i, j);
      else
        range.least = range.most = texel_alpha(t, i, j);
      const bool opaque = range.least >= s.limits.opaque_from;
      const bool transparent = range.most < s.limits.transparent_below;
      if ((opaque && s.opaque) || (transparent && s.transparent)) continue;
      const int left = i * size, top = j * size;
      const int right = std::min(left + size, t.width), bottom = std::min(top + size, t.height);
      if (!overlaps(s, left, top, right, bottom)) continue;
      if (opaque)
        s.opaque = true;
      else if (transparent)
        s.transparent = true;
      else if (level < 0)
        s.doubtful = true;
      else
        search(s, level - 1, std::max(x0, left), std::max(y0, top), std::min(x1, right - 1),
               std::min(y1, bottom - 1));
      if (s.is_over()) return;
    }
}

// The first and last repeat of an image along one axis that a triangle reaches into; the only one
// of a clamped image.
struct Repeats {
  double first = 0, last = 0;
};

Repeats repeats_of(double lower, double upper, double reach, Wrap wrap, int size) {
  if (wrap == Wrap::clamp_to_edge) return {};
  return {std::floor((lower - reach) / size), std::floor((upper + reach) / size)};
}

// Coordinates within one repeat of the image; with mirrored_repeat every other one is mirrored.
void place_in_repeat(const double (&from)[3], double repeat, Wrap wrap, int size, double (&to)[3]) {
  const bool mirrored = wrap == Wrap::mirrored_repeat && std::fmod(repeat, 2.0) != 0;
  for (int k = 0; k < 3; ++k)
    to[k] = mirrored ? (repeat + 1) * size - from[k] : from[k] - repeat * size;
}

int clamp_texel(double x, int size) {
  return static_cast<int>(std::clamp(std::floor(x), 0.0, size - 1.0));
}

void search_repeat(Search& s) {
  const TextureView& t = s.blocks.texture;
  const int x0 = clamp_texel(s.lower_x - s.reach_x, t.width);
  const int x1 = clamp_texel(s.upper_x + s.reach_x, t.width);
  const int y0 = clamp_texel(s.lower_y - s.reach_y, t.height);
  const int y1 = clamp_texel(s.upper_y + s.reach_y, t.height);
  // Start at the level where the triangle covers few squares.
  const int extent = std::max(x1 - x0, y1 - y0);
  int level = -1;
  for (int size = squares_a_side; 2 * size <= extent; size *= squares_a_side) ++level;
  search(s, std::min(level, static_cast<int>(s.blocks.levels.size()) - 1), x0, y0, x1, y1);
}

int wrap_texel(std::int64_t texel, Wrap wrap, int size) {
  if (texel >= 0 && texel < size) return static_cast<int>(texel);
  if (wrap == Wrap::clamp_to_edge) return texel < 0 ? 0 : size - 1;
  const std::int64_t period = wrap == Wrap::repeat ? size : 2 * static_cast<std::int64_t>(size);
  const auto k = static_cast<int>((texel % period + period) % period);
  return k < size ? k : 2 * size - 1 - k;
}

// Of a number that a 64-bit integer holds. std::floor is a call on processors without SSE 4.1.
std::int64_t floor_of(double x) {
  const auto towards_zero = static_cast<std::int64_t>(x);
  return towards_zero - (static_cast<double>(towards_zero) > x ? 1 : 0);
}

// A small triangle under bilinear filtering, by squares between four texel centres: within one
// alpha is bilinear, so that over a box its extremes lie at corners.
void search_squares(Search& s, double margin_x, double margin_y) {
  const TextureView& t = s.blocks.texture;
  const double left = s.lower_x - margin_x, right = s.upper_x + margin_x;
  const double top = s.lower_y - margin_y, bottom = s.upper_y + margin_y;
  const std::int64_t first_x = floor_of(left - 0.5), first_y = floor_of(top - 0.5);
  const int across = static_cast<int>(floor_of(right - 0.5) - first_x) + 1;
  const int down = static_cast<int>(floor_of(bottom - 0.5) - first_y) + 1;
  float centre[most_squares + 3][most_squares + 3];
  AlphaRange all{std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};
  for (int j = 0; j <= down; ++j) {
    const int y = wrap_texel(first_y + j, t.wrap_v, t.height);
    for (int i = 0; i <= across; ++i) {
      const float alpha = texel_alpha(t, wrap_texel(first_x + i, t.wrap_u, t.width), y);
      centre[j][i] = alpha;
      all.least = std::min(all.least, alpha);
      all.most = std::max(all.most, alpha);
    }
  }
  s.opaque = all.least >= s.limits.opaque_from;
  s.transparent = all.most < s.limits.transparent_below;
  if (s.opaque || s.transparent) return;
  for (int j = 0; j < down; ++j)
    for (int i = 0; i < across; ++i) {
      const double x = static_cast<double>(first_x + i) + 0.5;
      const double y = static_cast<double>(first_y + j) + 0.5;
      const double ax = std::max(left, x), bx = std::min(right, x + 1);
      const double ay = std::max(top, y), by = std::min(bottom, y + 1);
      if (!touches(s, ax - margin_x, ay - margin_y, bx + margin_x, by + margin_y)) continue;
      const auto between = [](double a, double b, double f) { return a * (1 - f) + b * f; };
      const auto alpha = [&](double px, double py) {
        return between(between(centre[j][i], centre[j][i + 1], px - x),
                       between(centre[j + 1][i], centre[j + 1][i + 1], px - x), py - y);
      };
      const auto [least, most] =
          std::minmax({alpha(ax, ay), alpha(bx, ay), alpha(ax, by), alpha(bx, by)});
      if (least >= s.limits.opaque_from)
        s.opaque = true;
      else if (most < s.limits.transparent_below)
        s.transparent = true;
      else
        s.doubtful = true;
      if (s.is_over()) return;
    }
}

}  // namespace

AlphaBlocks make_alpha_blocks(const TextureView& texture) {
  AlphaBlocks blocks{texture, {}};
  blocks.levels.push_back(make_level(texture.width, texture.height, [&](int x, int y) {
    const float alpha = texel_alpha(texture, x, y);
    return AlphaRange{alpha, alpha};
  }));
  while (blocks.levels.back().width > 1 || blocks.levels.back().height > 1) {
    const AlphaBlocks::Level& finer = blocks.levels.back();
    blocks.levels.push_back(
        make_level(finer.width, finer.height, [&](int x, int y) { return range_at(finer, x, y); }));
  }
  return blocks;
}

Opacity kind_of_texels(const AlphaBlocks& blocks, const AlphaLimits& limits,
                       const TexelTriangle& triangle) {
  const TextureView& t = blocks.texture;
  const auto kind = [](bool opaque, bool transparent) {
    return opaque ? Opacity::opaque : transparent ? Opacity::transparent : Opacity::ask;
  };
  const AlphaRange all = blocks.levels.back().ranges.front();
  const bool all_opaque = all.least >= limits.opaque_from;
  const bool all_transparent = all.most < limits.transparent_below;
  if (all_opaque || all_transparent) return kind(all_opaque, all_transparent);
  Search s{blocks, limits};
  // Bilinear reading gives a weight to texels whose centre is less than one texel away.
  const double half = t.filter == Filter::linear ? 0.5 : 0.0;
  s.reach_x = triangle.margin_x + half;
  s.reach_y = triangle.margin_y + half;
  const auto [lower_x, upper_x] = std::minmax_element(triangle.x, triangle.x + 3);
  const auto [lower_y, upper_y] = std::minmax_element(triangle.y, triangle.y + 3);
  const bool is_small = *upper_x - *lower_x + 2 * triangle.margin_x < most_squares &&
                        *upper_y - *lower_y + 2 * triangle.margin_y < most_squares;
  if (t.filter == Filter::linear && is_small) {
    std::copy(triangle.x, triangle.x + 3, s.x);
    std::copy(triangle.y, triangle.y + 3, s.y);
    prepare(s);
    search_squares(s, triangle.margin_x, triangle.margin_y);
    return s.is_over() ? Opacity::ask : kind(s.opaque, s.transparent);
  }
  const Repeats across = repeats_of(*lower_x, *upper_x, s.reach_x, t.wrap_u, t.width);
  const Repeats down = repeats_of(*lower_y, *upper_y, s.reach_y, t.wrap_v, t.height);
  if (across.last - across.first > most_repeats_searched ||
      down.last - down.first > most_repeats_searched)
    return Opacity::ask;
  for (double row = down.first; row <= down.last; ++row)
    for (double column = across.first; column <= across.last; ++column) {
      place_in_repeat(triangle.x, column, t.wrap_u, t.width, s.x);
      place_in_repeat(triangle.y, row, t.wrap_v, t.height, s.y);
      prepare(s);
      search_repeat(s);
      if (s.is_over()) return Opacity::ask;
    }
  return kind(s.opaque, s.transparent);
}

}  // namespace omma
