// Light that stands still, found once and looked up ever after: for each side of each triangle, or of
// cells of it where it is large, and for each instance, how much of it reaches the surface from the
// sky, from what shines and from all other surfaces. What comes straight from discs (the sun) and
// from lamps is left out: it is asked for at run time, as its shadows have edges.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "omma/scene.h"

namespace omma {

class World;

struct BakeSettings {
  double cell_m = 0;  // longest edge of cells on large triangles; 0: chosen by the scene
  int paths = 16;     // of light for each side of a cell, a multiple of 16 up to 65536
  std::size_t most_bytes = std::size_t{1} << 30;  // what has no room is lit by probes
};

// So that a cell of 16 bands lies in one line of a processor's cache.
struct alignas(64) BakedLine {
  std::uint16_t values[32];
};

// Numbers are of 16 bits without a sign: 5 of an exponent, 11 of a fraction (physics/baked.h).
struct BakedLight {
  int bands = 0;
  // What a value of 1 is, in the light's unit: the radiance of a white surface.
  double unit = 1;
  // [instance of the scene], its first cell; -1 where probes light it, or it has no triangles.
  std::vector<std::int32_t> first_cell;
  // [mesh][triangle + 1], the first cell of each triangle within its instance's; empty where each
  // has one.
  std::vector<std::vector<std::int32_t>> cell_of_triangle;
  std::int32_t cells = 0;
  std::vector<BakedLine> lines;  // [cell][front, back][band], one behind the other

  // A grid of places in the air, for what moves and what has no room: radiance of a white surface
  // that faces +X, -X, +Y, -Y, +Z, -Z there. In the frame that the world was traced in first.
  float probe_origin_m[3] = {0, 0, 0};
  float probe_spacing_m[3] = {1, 1, 1};
  std::int32_t probes[3] = {0, 0, 0};
  std::vector<std::uint16_t> probe_values;  // [z][y][x][direction][band]

  double cell_m = 0;        // the longest edge of a cell
  int paths = 0;
  std::int64_t by_probes = 0;  // triangles that have no room for cells
  double seconds = 0;       // that it took

  std::size_t bytes() const;
};

// Of a world that is lit by paths, as its things lie now. Throws omma::Error where settings are out of
// range, or cells of the size that was asked for do not fit (with what they need and what would fit),
// and omma::Cancelled where `progress`, told of the finished fraction, returns false. The same bits on
// any number of threads.
BakedLight bake_light(const World& world, const BakeSettings& settings = {},
                      const std::function<bool(double)>& progress = {});

// Throws omma::Error where it is not whole, or of other bands or another scene.
void check_baked_light(const BakedLight& baked, const Scene& scene, int bands);

}  // namespace omma
