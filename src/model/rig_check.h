// What must hold of a scene's rig before it is trusted.
#pragma once

#include "omma/scene.h"

namespace omma {

// Throws omma::Error that names the scene and the place, where the rig does not go with the scene's
// meshes and cameras or with itself.
void check_rig(const Scene& scene);

}  // namespace omma
