// Images in linear light with their coarser levels, and how densely triangles use them: what a ray
// with a footprint reads (physics/surface/texture.h).
#pragma once

#include <cstdint>
#include <vector>

#include "model/new_version.h"
#include "omma/scene.h"
#include "physics/views/scene_view.h"

namespace omma {

// What 8-bit codes of colour stand for: light in sRGB, or their own values from 0 to 1, as of
// CompoundRay's colours, which are raised to their power after interpolation, and of normals.
enum class ImageCodes : std::uint8_t { srgb, linear };

// Images of more texels altogether are large: there memory counts for more than the last of speed.
inline constexpr std::size_t most_fast_texels = std::size_t(1) << 24;

// Laid out as TextureView says; 8-bit images become 16-bit linear light. What the image itself has
// as it is needed stays there.
struct TextureLevels {
  std::vector<std::int32_t> linear16;
  std::vector<float> linear;
  std::vector<std::int32_t> value_of_code;  // [256], where level 0 stays 8-bit
  std::vector<std::int32_t> first_texel;    // [level]
  Version version = new_version();
};

// Where alpha blends, colours are averaged with it as weight. The image alone, where `levels` is
// false; float images are then left where they are, and 8-bit images where they are `large`, whose
// level 0 stays 8-bit in any case: half the memory, and the same light.
TextureLevels make_texture_levels(const Image& image, ImageCodes codes, AlphaMode alpha,
                                  bool levels, bool large = false);

// `levels` and the image stay where they are.
TextureView view_levels(const Image& image, const TextureLevels& levels);

// Texels per metre of the mesh along the direction in which they are least dense, [triangle]; 0
// where a triangle has no area in space or in the image. `uvs`: of vertices or [triangle][3].
std::vector<float> texel_density(const Mesh& mesh, const Vec2* uvs, bool of_vertices,
                                 const TextureView& texture);

// The same of an equirectangular image, per rad.
float panorama_density(const TextureView& image);

}  // namespace omma
