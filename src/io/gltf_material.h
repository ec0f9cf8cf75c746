// Materials of a glTF file with the textures and images they use.
#pragma once

#include "io/gltf_container.h"
#include "io/gltf_warnings.h"
#include "omma/scene.h"

namespace omma {

// Fills scene.materials (all of the file, same indices) and the textures and images that they use,
// decoded; how they scatter light, and the textures of that, only where `scattering` is asked for.
// Throws omma::Error that names path, material or image.
void read_materials(GltfContainer& gltf, Scene& scene, GltfWarnings& warnings, bool scattering,
                    const WorkPart& work);

}  // namespace omma
