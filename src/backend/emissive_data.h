// Surfaces that shine, as the physics reads them (LightData::emissive): trees over triangles in
// their meshes' frames, and one over the instances.
#pragma once

#include <vector>

#include "backend/light_data.h"

namespace omma {

// Fills in all that LightData has of them; gives what they send to a place at this distance from
// the middle of the scene, [band].
std::vector<double> make_emissive(LightData& data, const Light& light, const Scene& scene,
                                  const Placement& placement, const SceneView& view,
                                  double distance_m);

// Surfaces that shine are where the frames of their instances are now, as SceneView has these.
void place_emissive(LightData& data, const float* frame_from_mesh);

}  // namespace omma
