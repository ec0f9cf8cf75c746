// What must hold of Gaussian splats before they are rendered.
#pragma once

#include "omma/scene.h"

namespace omma {

// Throws omma::Error that begins with scene.path and names the cloud and the splat.
void check_splats(const Scene& scene);

}  // namespace omma
