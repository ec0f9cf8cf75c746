// Materials of a glTF file with the textures and images they use.
#pragma once

#include "io/gltf_container.h"
#include "io/gltf_warnings.h"
#include "omma/scene.h"

namespace omma {

// Fills scene.materials (all of the file, same indices) and the textures and images that their base
// colour and emission use, decoded. Throws omma::Error that names path, material or image.
void read_materials(GltfContainer& gltf, Scene& scene, GltfWarnings& warnings,
                    const WorkPart& work);

// One image, decoded. There is an image of that index.
Image read_gltf_image(GltfContainer& gltf, int index);

// The image of a texture, decoded, and how it is sampled. There is a texture of that index; throws
// omma::Error that names path, texture or image, or `place` where the texture has no image.
Image read_gltf_texture(GltfContainer& gltf, int index, const std::string& place,
                        Texture& sampling);

}  // namespace omma
