// Asked by Embree for every candidate hit on a mesh that a ray may not see, or may see through.
#pragma once

#include "backend/embree/embree_api.h"
#include "physics/views/scene_view.h"

namespace omma {

// The filter that a mesh of this material needs, or null.
RTCFilterFunctionN filter_for(const MaterialView& material);

}  // namespace omma
