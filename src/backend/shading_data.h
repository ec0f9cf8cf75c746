// A Scene turned into the flat arrays that the physics reads: texture coordinates per triangle
// corner (in large scenes per vertex) with their transforms applied, images in linear light. Shared
// by all backends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "backend/opacity_maps.h"
#include "backend/texture_levels.h"
#include "omma/scene.h"
#include "physics/views/scene_view.h"

namespace omma {

// Scenes of more triangles are large: there memory counts for more than the last of speed.
inline constexpr std::size_t most_fast_triangles = std::size_t(1) << 22;

bool is_large(const Scene& scene);

// Owns what its `view` points to; it also points into the images and meshes of the Scene, which
// must outlive it. Not to be copied: the views are addresses.
struct ShadingData {
  ShadingData() = default;
  ShadingData(const ShadingData&) = delete;
  ShadingData& operator=(const ShadingData&) = delete;

  std::vector<MeshView> meshes;
  std::vector<MaterialView> materials;
  std::vector<TextureView> textures;
  std::vector<std::vector<Vec2>> uvs;         // of corners or vertices, see MeshView
  std::vector<std::vector<Vec4>> colors;      // of corners
  std::vector<std::vector<float>> densities;  // of texels, [textured mesh][triangle]
  std::list<TextureLevels> levels;            // of the images, where they stay
  // What is in `textures` and `levels`: by texture and use, by image, use and whether it has
  // levels.
  std::map<std::tuple<int, AlphaMode, ImageCodes>, std::int32_t> view_of_texture;
  std::map<std::tuple<int, AlphaMode, ImageCodes, bool>, TextureLevels*> levels_of_image;
  std::vector<float> power_22;  // see SceneView, or empty
  OpacityMaps opacity;          // of cut-outs
  SceneView view;               // without a background
};

// A background for the physics. Owns what its `view` points to, or points into the Background.
struct BackgroundData {
  TextureLevels levels;
  BackgroundView view;
};

std::unique_ptr<ShadingData> make_shading_data(const Scene& scene);
BackgroundData make_background_data(const Background& background);

}  // namespace omma
