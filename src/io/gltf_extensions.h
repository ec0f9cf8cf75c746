// Which extensions of glTF are read, and what is said of the others.
#pragma once

#include "io/gltf_container.h"
#include "io/gltf_warnings.h"

namespace omma {

// Throws omma::Error where the file requires an extension that is not read; of others that it has it
// warns, by what may be missing from the picture.
void check_gltf_extensions(const GltfContainer& gltf, GltfWarnings& warnings);

}  // namespace omma
