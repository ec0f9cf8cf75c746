// The node tree of a glTF file: who is whose child, and where a node sits in its parent.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "omma/vec.h"

namespace omma {

struct GltfNode {
  std::string place;  // for errors, such as "scene.gltf: node 3 \"head\""
  std::string name;
  std::vector<int> children;
  int mesh = -1, camera = -1, skin = -1, light = -1;         // -1 for none
  bool is_visible = true;                                    // with all below it
  std::vector<double> matrix, translation, rotation, scale;  // as in the file, or empty
  std::vector<double> weights;                               // of morph targets, or empty
};

struct NodeParts {
  std::array<double, 3> translation_m{0, 0, 0};
  std::array<double, 4> rotation{0, 0, 0, 1};  // unit quaternion x, y, z, w
  std::array<double, 3> scale{1, 1, 1};
};

// The nodes of a document that check_gltf_schema has passed.
std::vector<GltfNode> read_gltf_nodes(const nlohmann::json& document, const std::string& path);

// Parent of each node, -1 for none. Throws omma::Error where a node has two parents, is its own
// ancestor or names a child that is not there (glTF 2.0, section 3.5.2).
std::vector<int> gltf_node_parents(const std::vector<GltfNode>& nodes);

// Of a node without a matrix. Throws omma::Error where its rotation is none.
NodeParts gltf_node_parts(const GltfNode& node);

// parent_from_node = translation * rotation * scale, or the matrix.
Mat4 gltf_node_transform(const GltfNode& node);

}  // namespace omma
