// What is small and bright in a scene besides the discs of its sky: mirror images of those in smooth
// flat surfaces, and surfaces that shine. Ommatidia aim rays of their own at it (physics/block/aimed_rays.h).
#pragma once

#include <vector>

#include "backend/light_data.h"

namespace omma {

// In the light's unit, of where things are now: what moves later is still found by other rays.
// `view` is of the scene's shading data, with `scatter` set.
std::vector<AimView> make_aims(const LightData& data, const Scene& scene, const Placement& placement,
                               const SceneView& view);

}  // namespace omma
