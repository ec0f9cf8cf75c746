// The node tree of a glTF file.
#include "io/gltf_nodes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "io/gltf_container.h"
#include "io/gltf_lights.h"
#include "model/transform.h"
#include "omma/error.h"

namespace omma {

using nlohmann::json;

std::vector<GltfNode> read_gltf_nodes(const json& document, const std::string& path) {
  std::vector<GltfNode> nodes;
  for (const json& description : gltf_list(document, "nodes")) {
    GltfNode node;
    node.name = description.value("name", "");
    node.place = path + ": node " + std::to_string(nodes.size()) + gltf_name(description);
    node.children = description.value("children", std::vector<int>());
    node.mesh = description.value("mesh", -1);
    node.camera = description.value("camera", -1);
    node.skin = description.value("skin", -1);
    node.light = gltf_extension(description, lights_extension).value("light", -1);
    node.is_visible = gltf_extension(description, "KHR_node_visibility").value("visible", true);
    node.matrix = description.value("matrix", std::vector<double>());
    node.translation = description.value("translation", std::vector<double>());
    node.rotation = description.value("rotation", std::vector<double>());
    node.scale = description.value("scale", std::vector<double>());
    node.weights = description.value("weights", std::vector<double>());
    nodes.push_back(std::move(node));
  }
  return nodes;
}

std::vector<int> gltf_node_parents(const std::vector<GltfNode>& nodes) {
  enum class State : std::uint8_t { unseen, open, done };
  std::vector<State> state(nodes.size(), State::unseen);
  std::vector<int> parent(nodes.size(), -1);
  struct Visit {
    std::size_t node, next_child;
  };
  std::vector<Visit> path;
  for (std::size_t start = 0; start < nodes.size(); ++start) {
    if (state[start] == State::unseen) path.push_back({start, 0});
    while (!path.empty()) {
      Visit& visit = path.back();
      state[visit.node] = State::open;
      if (visit.next_child == nodes[visit.node].children.size()) {
        state[visit.node] = State::done;
        path.pop_back();
        continue;
      }
      const auto child = static_cast<std::size_t>(nodes[visit.node].children[visit.next_child++]);
      if (child >= nodes.size())
        throw Error(nodes[visit.node].place + ": its child " + std::to_string(child) +
                    " is not there; there are " + std::to_string(nodes.size()) + " nodes");
      if (state[child] == State::open)
        throw Error(nodes[child].place + ": the node graph has a cycle: it is its own ancestor");
      if (parent[child] >= 0)
        throw Error(nodes[child].place + ": has two parents, nodes " +
                    std::to_string(parent[child]) + " and " + std::to_string(visit.node));
      parent[child] = static_cast<int>(visit.node);
      if (state[child] == State::unseen) path.push_back({child, 0});
    }
  }
  return parent;
}

NodeParts gltf_node_parts(const GltfNode& node) {
  NodeParts parts;
  std::copy(node.translation.begin(), node.translation.end(), parts.translation_m.begin());
  std::copy(node.scale.begin(), node.scale.end(), parts.scale.begin());
  if (node.rotation.empty()) return parts;
  double squares = 0;
  for (const double x : node.rotation) squares += x * x;
  const double size = std::sqrt(squares);
  if (!(size > 1e-6) || !std::isfinite(size))
    throw Error(node.place + ": rotation: is not a unit quaternion");
  for (std::size_t i = 0; i < 4; ++i) parts.rotation[i] = node.rotation[i] / size;
  return parts;
}

Mat4 gltf_node_transform(const GltfNode& node) {
  Mat4 t;
  if (!node.matrix.empty()) {  // column major
    for (std::size_t c = 0; c < 4; ++c)
      for (std::size_t r = 0; r < 4; ++r) t.m[r][c] = node.matrix[4 * c + r];
    if (t.m[3][0] != 0 || t.m[3][1] != 0 || t.m[3][2] != 0 || t.m[3][3] != 1)
      throw Error(node.place + ": matrix: its bottom row is not 0 0 0 1");
    return t;
  }
  const NodeParts parts = gltf_node_parts(node);
  return transform_of(parts.translation_m, parts.rotation, parts.scale);
}

}  // namespace omma
