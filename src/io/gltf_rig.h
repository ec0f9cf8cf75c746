// What moves in a glTF file: animations, skins, and the nodes that both are about.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "io/gltf_container.h"
#include "io/gltf_nodes.h"
#include "io/gltf_warnings.h"
#include "omma/rig.h"

namespace omma {

// What the loader has found on its way through the nodes.
struct GltfRigParts {
  // `node` and `skin` are still indices of the file.
  std::vector<Deformation> deformations;
  std::vector<int> instance_of_deformation;  // the first in the scene that has its mesh
  std::map<int, int> camera_of_node;         // indices of the file's node, of the scene's camera
  std::vector<int> lamp_nodes, hit_box_nodes;  // of the file, which are not moved
};

// Which nodes of the file an animation blends between morph targets.
std::vector<char> gltf_blended_nodes(const GltfContainer& gltf, std::size_t nodes);

// How many joints a skin of the file has.
std::size_t gltf_joint_count(const GltfContainer& gltf, int skin, const std::string& user);

// Puts the scene's rig together, if anything moves, and gives its meshes the shape in which the file
// shows them. Throws omma::Error that names the place, such as "animations[0].samplers[1].input".
void read_rig(GltfContainer& gltf, const std::vector<GltfNode>& nodes,
              const std::vector<int>& parent, GltfRigParts parts, GltfWarnings& warnings,
              Scene& scene);

}  // namespace omma
