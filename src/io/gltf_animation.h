// The animations of a glTF file (section 3.11).
#pragma once

#include <string>
#include <vector>

#include "io/gltf_accessor.h"
#include "io/gltf_container.h"
#include "io/gltf_nodes.h"
#include "io/gltf_warnings.h"
#include "omma/rig.h"

namespace omma {

// All of them; a channel's `node` is an index of the file. `targets`: of each node of the file, how
// many morph targets its mesh has.
std::vector<Animation> read_gltf_animations(GltfContainer& gltf,
                                            const std::vector<GltfNode>& nodes,
                                            const std::vector<std::size_t>& targets,
                                            GltfWarnings& warnings);

// An accessor whose errors begin with who uses it, such as "scene.gltf: skins[0]".
GltfAccessor read_accessor_of(GltfContainer& gltf, int index, const std::string& user);

}  // namespace omma
