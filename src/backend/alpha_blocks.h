// A min-max pyramid of a texture's alpha: it bounds what a read anywhere in a triangle can give
// (backend/opacity_maps).
#pragma once

#include <vector>

#include "physics/surface/opacity.h"
#include "physics/views/scene_view.h"

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

// From opaque_from on a cut-out is opaque however alpha is rounded; below transparent_below it is
// transparent.
struct AlphaLimits {
  double opaque_from = 0;        // at least this
  double transparent_below = 0;  // less than this
};

// A triangle in texture coordinates times the size of the image, not wrapped.
struct TexelTriangle {
  double x[3], y[3];
  double margin_x = 0, margin_y = 0;  // texels: how far off the arithmetic of a read may be
};

// Opaque or transparent where that holds for every texel that a read in the triangle weights; else
// `ask`.
Opacity kind_of_texels(const AlphaBlocks& blocks, const AlphaLimits& limits,
                       const TexelTriangle& triangle);

}  // namespace omma
