// What a lit world has besides what is built of its scene: how surfaces scatter, what shines, and
// the view of both that the physics reads.
#pragma once

#include <memory>
#include <vector>

#include "backend/light_data.h"
#include "backend/make_sun_map.h"
#include "backend/scatter_data.h"
#include "backend/shading_data.h"
#include "omma/world.h"

namespace omma {

// Baked light as the physics reads it, and what of the light it leaves out.
struct BakedReading {
  LightView left_out;
  std::vector<DiscView> discs_alone;
  std::vector<float> discs_sent;      // [band], KindView's
  std::vector<MeshCells> mesh_cells;  // [mesh]
  BakedView view;
};

// Owns what its `view` points to, but for the scene's own arrays and the frames of its instances.
struct LitData {
  std::shared_ptr<ShadingData> shading;  // with what light reads of meshes
  std::unique_ptr<ScatterData> scatter;
  std::unique_ptr<LightData> light;
  std::vector<float> albedos, coat_albedo, metal_albedo;  // see SceneView
  std::vector<std::vector<float>> emission;               // [material that shines][band][3]
  std::vector<float> splat_emission;                      // [band][channel], where there are splats
  std::shared_ptr<const BakedLight> baked_light;
  BakedReading baked;
  SunMapData sun_map;
  SceneView view;  // without a background
};

// What of a world changes as things move, and where it is kept.
struct MovingFrames {
  const float* frame_from_mesh;    // as in SceneView
  Vec3d lamp_origin_m;             // of the frame that lamps are placed in, in the world
  const float* lamp_origin_now_m;  // [3], the same in the traced frame
  const char* moves;               // [instance], as in BakedView
};

// How baked light is read with the light that it was baked of; both stay where they are.
void read_baked(const BakedLight& baked, const LightData& light, const MovingFrames& frames,
                BakedReading& reading);

// Of a checked lighting and scene.
std::unique_ptr<LitData> make_lit_data(const Lighting& lighting, const Scene& scene,
                                       const Placement& placement, const MovingFrames& frames);

}  // namespace omma
