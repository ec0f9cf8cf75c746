// Least and most alpha of a texture in ever larger squares, by which it is soon found what texels
// reading it anywhere in a triangle can meet (backend/opacity_maps).
#pragma once

#include <vector>

#include "physics/opacity.h"
#include "physics/scene_view.h"

namespace omma {

struct AlphaRange {
  float least, most;
};

struct AlphaBlocks {
  // Squares of 4, 16, 64 ... texels a side, the last level one square.
  struct Level {
    int width = 0, height = 0;
    std::vector<AlphaRange> ranges;  // [height][width]
  };
  TextureView texture;
  std::vector<Level> levels;
};

// Of level 0, the image itself.
AlphaBlocks make_alpha_blocks(const TextureView& texture);

// Alpha that lets a cut-out be seen surely, and that surely does not.
struct AlphaLimits {
  double opaque_from = 0;        // at least this
  double transparent_below = 0;  // less than this
};

// A triangle in texture coordinates times the size of the image, not wrapped.
struct TexelTriangle {
  double x[3], y[3];
  double margin_x = 0, margin_y = 0;  // texels: how far off the arithmetic of a read may be
};

// What all texels are that reads in the triangle give a weight to; else `ask`.
Opacity kind_of_texels(const AlphaBlocks& blocks, const AlphaLimits& limits,
                       const TexelTriangle& triangle);

}  // namespace omma
