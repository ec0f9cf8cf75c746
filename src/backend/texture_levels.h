// Images in linear light with their coarser levels, and how densely triangles use them: what a ray
// with a footprint reads (kernel/texture.h).
#pragma once

#include <cstdint>
#include <vector>

#include "kernel/scene_view.h"

namespace omma {

// What the alpha of an image is for: nothing, the share of light that it covers, or to be cut out
// where it is below a cutoff. Colours are averaged with the weight that they are seen with.
struct AlphaUse {
  AlphaMode mode = AlphaMode::opaque;
  float cutoff = 0;  // of the image's own alpha, for `mask`

  auto operator<=>(const AlphaUse&) const = default;
};

// Exactly one of the two arrays is filled, laid out as TextureView says; 8-bit images become 16-bit
// linear light.
struct TextureLevels {
  std::vector<std::int32_t> linear16;
  std::vector<float> linear;
  std::vector<std::int32_t> first_texel;  // [level]
};

// The image alone, where `levels` is false; float images are then left where they are.
TextureLevels make_texture_levels(const Image& image, ColorRule rule, AlphaUse alpha, bool levels);

// `levels` and the image stay where they are.
TextureView view_levels(const Image& image, const TextureLevels& levels);

// Texels per metre of the mesh along the direction in which they are least dense, [triangle]; 0
// where a triangle has no area in space or in the image. `uvs`: of vertices or [triangle][3].
std::vector<float> texel_density(const Mesh& mesh, const std::vector<Vec2>& uvs, bool of_vertices,
                                 const TextureView& texture);

// The same of an equirectangular image, per rad.
float panorama_density(const TextureView& image);

}  // namespace omma
