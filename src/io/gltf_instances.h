// EXT_mesh_gpu_instancing: one node that places its mesh many times.
#pragma once

#include <vector>

#include "io/gltf_container.h"
#include "io/gltf_nodes.h"
#include "io/gltf_warnings.h"

namespace omma {

// Each instance becomes a node of its own, a child of the one that has them, at the end of `nodes`
// and `parent`; the mesh moves to them. Throws omma::Error that names the node and the member.
void place_gltf_instances(GltfContainer& gltf, std::vector<GltfNode>& nodes,
                          std::vector<int>& parent, GltfWarnings& warnings);

}  // namespace omma
