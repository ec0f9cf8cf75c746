// How the surfaces of a Scene scatter light in the bands of a Light, as flat arrays. Made only
// where a world has a light.
#pragma once

#include <list>
#include <memory>
#include <vector>

#include "backend/shading_data.h"
#include "omma/light.h"
#include "physics/views/scene_view.h"

namespace omma {

// Owns what the views point to, but for emission and specular_albedo, which are null here. Not to
// be copied: the views are addresses.
struct ScatterData {
  ScatterData() = default;
  ScatterData(const ScatterData&) = delete;
  ScatterData& operator=(const ScatterData&) = delete;

  std::vector<ScatterView> materials;  // [material of the scene, then glTF's default]
  std::list<std::vector<float>> matrices;
  std::list<FactorTextures> factors;  // of meshes whose material has any
  std::vector<float> boundaries;      // SceneView::boundaries
};

// Adds to `shading` what meshes read with light: textures of scattering, their coordinates,
// normals. The scene is validated and outlives both. `light.ultraviolet` may have one element more
// than there are materials, for meshes without one.
std::unique_ptr<ScatterData> make_scatter_data(const Scene& scene, const Light& light,
                                               ShadingData& shading);

// Materials in use of which nothing is known in the bands' part below 400 nm, or not in all of it:
// RGB says nothing there, and a table may end before. Ascending; -1 for meshes without a material.
std::vector<int> materials_without_ultraviolet(const Scene& scene, const Bands& bands);

}  // namespace omma
