// Lamps of a glTF file: KHR_lights_punctual.
#pragma once

#include "io/gltf_container.h"
#include "io/gltf_nodes.h"
#include "omma/scene.h"

namespace omma {

inline constexpr const char* lights_extension = "KHR_lights_punctual";

// Adds the lamp that a node has. Throws omma::Error that names node or light.
void read_light(GltfContainer& gltf, const GltfNode& node, const Mat4& world_from_node,
                Scene& scene);

// The extension's member "lights[]" for a lamp; its node has the name and the transform.
nlohmann::json written_light(const PunctualLight& light);

}  // namespace omma
