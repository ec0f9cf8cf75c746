// A Scene turned into the flat arrays the kernels read: texture coordinates per triangle corner
// with their transforms applied, images in linear light. Shared by all backends.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "kernel/scene_view.h"

namespace omma {

// Owns what its `view` points to; it also points into the images of the Scene and the Background,
// which must outlive it. Not to be copied: the views are addresses.
struct ShadingData {
  ShadingData() = default;
  ShadingData(const ShadingData&) = delete;
  ShadingData& operator=(const ShadingData&) = delete;

  std::vector<MeshView> meshes;
  std::vector<MaterialView> materials;
  std::vector<TextureView> textures;
  std::vector<std::vector<Vec2>> corner_uvs;
  std::vector<std::vector<Vec4>> corner_colors;
  std::vector<std::vector<std::int32_t>> linear16;  // [image], of the 8-bit ones; background last
  SceneView view;
};

std::unique_ptr<ShadingData> make_shading_data(const Scene& scene, const Background& background);

}  // namespace omma
