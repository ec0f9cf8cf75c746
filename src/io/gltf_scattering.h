// How materials of a glTF file scatter light.
#pragma once

#include "io/gltf_textures.h"

namespace omma {

// Fills what glTF 2.0 and its extensions say of scattering, the spectra in the material's extras,
// and the textures of both. What is not read of it is warned of.
void read_scattering(GltfTextureReader& reader, const nlohmann::json& material,
                     const std::string& place, Material& result);

}  // namespace omma
