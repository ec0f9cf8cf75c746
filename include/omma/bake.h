// Light that stands still, found once and looked up ever after: for each side of each triangle, or of
// cells of it where it is large, and for each instance, how much of it reaches the surface from the
// sky, from what shines and from all other surfaces. What comes straight from discs (the sun) and
// from lamps is left out: it is asked for at run time, as its shadows have edges.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "omma/baked_cell.h"
#include "omma/scene.h"

namespace omma {

class World;

struct BakeSettings {
  double cell_m = 0;  // longest edge of cells on large triangles; 0: chosen by the scene
  // Of light for each side of a cell: a multiple of 16 up to 65536. 0: more where there is more
  // noise, 12 in the mean of a large scene.
  int paths = 0;
  std::size_t most_bytes = std::size_t{1} << 30;  // what has no room is lit by probes
  std::uint32_t seed = 0;                         // of its random numbers
};

// Numbers are of 16 bits without a sign: 5 of an exponent, 11 of a fraction (physics/path/baked.h).
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
  std::vector<BakedLine> lines;   // [cell][front, back][band], one behind the other
  std::vector<CellError> errors;  // [cell][front, back]

  // A grid of places in the air, for what moves and what has no room: radiance of a white surface
  // that faces +X, -X, +Y, -Y, +Z, -Z there. In the frame that the world was traced in first.
  float probe_origin_m[3] = {0, 0, 0};
  float probe_spacing_m[3] = {1, 1, 1};
  std::int32_t probes[3] = {0, 0, 0};
  std::vector<std::uint16_t> probe_values;  // [z][y][x][direction][band]

  double cell_m = 0;           // the longest edge of a cell
  double paths = 0;            // of a side, in the mean over all
  std::int64_t by_probes = 0;  // triangles that have no room for cells
  double seconds = 0;          // that it took
  // Standard errors of sides of cells as fractions of their light: of half of them it is less, and
  // of 95 in 100.
  double error_median = 0, error_95 = 0;

  std::size_t bytes() const;
};

// What is finished of a bake that was cancelled, from which the same bake goes on.
struct UnfinishedBake {
  int pass = 0;                     // 0: it has not begun
  bool gathers = false;             // whether paths end on what the pass before has baked
  double unit = 0, seconds = 0;     // as in BakedLight, so far
  double share = 0;                 // of the work
  std::vector<std::uint8_t> done;   // [half][chunk of cells] of the pass, whether it is finished
  std::vector<BakedLine> lines[4];  // [odd, even passes][half], as BakedLight::lines
  std::vector<std::uint16_t> paths_of_group;  // of a half in this pass, but the first
};

// Of a world that is lit by paths, as its things lie now. Throws omma::Error where settings are out of
// range, or cells of the size that was asked for do not fit (with what they need and what would fit),
// and omma::Cancelled where `progress`, told of the finished fraction, returns false; `unfinished`,
// where not null, holds what was finished then, and what it holds at first is not done again. The same
// bits on any number of threads, with interruptions or without.
BakedLight bake_light(const World& world, const BakeSettings& settings = {},
                      const std::function<bool(double)>& progress = {},
                      UnfinishedBake* unfinished = nullptr);

struct BakeCost {
  std::int64_t cells = 0, by_probes = 0;
  std::size_t bytes = 0;  // of memory, when it is finished; five times as much on the way
  double seconds = 0;     // that it takes on the world's threads, at most, about
};

// What `bake_light` would take, from a few of its cells. Throws omma::Error and omma::Cancelled as that.
BakeCost bake_cost(const World& world, const BakeSettings& settings = {});

// Throws omma::Error where it is not whole, or of other bands or another scene.
void check_baked_light(const BakedLight& baked, const Scene& scene, int bands);

}  // namespace omma
