// Puts together what moves: which nodes matter, skins, and the shape of meshes as they stand.
#include "io/gltf_rig.h"

#include <algorithm>
#include <cmath>

#include "io/gltf_animation.h"
#include "model/animation.h"
#include "model/deform.h"
#include "model/transform.h"
#include "omma/error.h"

namespace omma {
namespace {

using nlohmann::json;

std::vector<std::size_t> target_counts(const GltfContainer& gltf,
                                       const std::vector<GltfNode>& nodes) {
  const json& meshes = gltf_list(gltf.document, "meshes");
  std::vector<std::size_t> counts;
  for (const GltfNode& node : nodes) {
    std::size_t count = 0;
    if (node.mesh >= 0 && static_cast<std::size_t>(node.mesh) < meshes.size())
      for (const json& primitive : meshes[static_cast<std::size_t>(node.mesh)]["primitives"])
        if (primitive.contains("targets")) count = std::max(count, primitive["targets"].size());
    counts.push_back(count);
  }
  return counts;
}

// Weights of morph targets as the file shows them: the node's, else the mesh's, else none.
std::vector<double> shown_weights(const GltfContainer& gltf, const GltfNode& node,
                                  std::size_t targets) {
  std::vector<double> weights = node.weights;
  if (weights.empty())
    weights = gltf_list(gltf.document, "meshes")[static_cast<std::size_t>(node.mesh)].value(
        "weights", std::vector<double>());
  if (weights.empty()) weights.resize(targets, 0.0);
  if (weights.size() != targets)
    throw Error(node.place + ": weights: expected " + std::to_string(targets) +
                ", one for each morph target, found " + std::to_string(weights.size()));
  return weights;
}

Skin read_skin(GltfContainer& gltf, int index, std::size_t nodes) {
  const json& source = gltf_list(gltf.document, "skins")[static_cast<std::size_t>(index)];
  const std::string place = gltf.path + ": skins[" + std::to_string(index) + "]";
  Skin skin;
  skin.name = source.value("name", "");
  skin.joints = source["joints"].get<std::vector<int>>();
  for (std::size_t j = 0; j < skin.joints.size(); ++j)
    if (static_cast<std::size_t>(skin.joints[j]) >= nodes)
      throw Error(place + ".joints[" + std::to_string(j) + "]: refers to node " +
                  std::to_string(skin.joints[j]) + ", there are " + std::to_string(nodes));
  skin.joint_from_mesh.resize(skin.joints.size());
  if (!source.contains("inverseBindMatrices")) return skin;
  const std::string matrices = place + ".inverseBindMatrices";
  const GltfAccessor accessor =
      read_accessor_of(gltf, source["inverseBindMatrices"].get<int>(), matrices);
  if (!accessor.matrix || accessor.components != 16 || accessor.count < skin.joints.size())
    throw Error(matrices + ": expected a 4 x 4 matrix for each of " +
                std::to_string(skin.joints.size()) + " joints, found " +
                std::to_string(accessor.count) + " elements of " +
                std::to_string(accessor.components) + " components");
  gltf.budget.spend(accessor.count, 16 * sizeof(double));
  std::vector<double> values(16 * accessor.count);
  read_doubles(accessor, values);
  for (std::size_t j = 0; j < skin.joints.size(); ++j) {
    const double* m = &values[16 * j];  // column major
    for (std::size_t c = 0; c < 4; ++c)
      for (std::size_t r = 0; r < 3; ++r) skin.joint_from_mesh[j].m[r][c] = m[4 * c + r];
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || std::fabs(m[15] - 1) > 1e-6)
      throw Error(matrices + ": the bottom row of matrix " + std::to_string(j) +
                  " is not 0 0 0 1");
  }
  return skin;
}

// Nodes of the file that the scene's rig needs: those that move a mesh, bones, and all their
// ancestors.
std::vector<char> needed_nodes(const std::vector<GltfNode>& nodes, const std::vector<int>& parent,
                               const std::vector<char>& moves, const GltfRigParts& parts,
                               const std::vector<Skin>& skins, const Scene& scene) {
  std::vector<char> needed(nodes.size(), 0);
  for (const Instance& instance : scene.instances) {
    const auto node = static_cast<std::size_t>(instance.node);
    if (moves[node]) needed[node] = 1;
  }
  for (const auto& [node, camera] : parts.camera_of_node)
    if (moves[static_cast<std::size_t>(node)]) needed[static_cast<std::size_t>(node)] = 1;
  for (const Deformation& deformation : parts.deformations)
    if (!deformation.targets.empty()) needed[static_cast<std::size_t>(deformation.node)] = 1;
  for (const Skin& skin : skins)
    for (const int joint : skin.joints) needed[static_cast<std::size_t>(joint)] = 1;
  for (std::size_t n = 0; n < nodes.size(); ++n)
    for (int up = parent[n]; needed[n] && up >= 0; up = parent[static_cast<std::size_t>(up)]) {
      if (needed[static_cast<std::size_t>(up)] == 2) break;
      needed[static_cast<std::size_t>(up)] = 2;
    }
  return needed;
}

// Of nodes that an animation moves or that hang from one.
std::vector<char> moving_nodes(const std::vector<Animation>& animations,
                               const std::vector<GltfNode>& nodes) {
  std::vector<char> moves(nodes.size(), 0);
  std::vector<int> open;
  for (const Animation& animation : animations)
    for (const AnimationChannel& channel : animation.channels)
      if (channel.part != AnimatedPart::weights) open.push_back(channel.node);
  while (!open.empty()) {
    const auto node = static_cast<std::size_t>(open.back());
    open.pop_back();
    if (moves[node]) continue;
    moves[node] = 1;
    open.insert(open.end(), nodes[node].children.begin(), nodes[node].children.end());
  }
  return moves;
}

RigNode rig_node(const GltfContainer& gltf, const GltfNode& node, std::size_t targets) {
  RigNode made;
  made.name = node.name;
  made.has_matrix = !node.matrix.empty();
  if (made.has_matrix) {
    made.matrix = gltf_node_transform(node);
  } else {
    const NodeParts parts = gltf_node_parts(node);
    made.translation_m = parts.translation_m;
    made.rotation = parts.rotation;
    made.scale = parts.scale;
  }
  if (targets > 0) made.weights = shown_weights(gltf, node, targets);
  return made;
}

// Gives meshes the shape that they have in the file. Deformations that no animation changes are
// dropped, but those by bones of meshes whose own node moves: bones alone place what they bend.
void shape_meshes(Rig& rig, const std::vector<int>& instances, Scene& scene) {
  const RigPose rest = eval_rig(rig, {}, 0);
  const std::vector<char> moves = nodes_that_move(rig);
  std::vector<Deformation> animated;
  for (std::size_t d = 0; d < rig.deformations.size(); ++d) {
    Deformation& deformation = rig.deformations[d];
    Instance& instance = scene.instances[static_cast<std::size_t>(instances[d])];
    // glTF ignores the transform of a skinned mesh's own node; vertices are stored in that node's
    // frame here, so that moving the node moves the mesh.
    if (deformation.skin >= 0) {
      if (!(std::fabs(determinant(instance.world_from_mesh)) > least_determinant))
        for (Instance& one : scene.instances)
          if (one.node == instance.node) one.world_from_mesh = {};
      deformation.mesh_from_world = inverse(instance.world_from_mesh);
    }
    Shape shape = eval_shape(rig, deformation, rest);
    Mesh& mesh = scene.meshes[static_cast<std::size_t>(deformation.mesh)];
    shape.positions.reserve(shape.positions.size() + 1);  // as the reader leaves them
    mesh.positions = std::move(shape.positions);
    mesh.normals = std::move(shape.normals);
    const auto is_own = [&](const RigNode& node) { return node.file_node == instance.node; };
    const auto own = std::find_if(rig.nodes.begin(), rig.nodes.end(), is_own);
    const bool own_moves =
        own != rig.nodes.end() && moves[static_cast<std::size_t>(own - rig.nodes.begin())] != 0;
    if (is_animated(rig, deformation, moves) || (deformation.skin >= 0 && own_moves))
      animated.push_back(std::move(deformation));
  }
  rig.deformations = std::move(animated);
}

}  // namespace

std::vector<char> gltf_blended_nodes(const GltfContainer& gltf, std::size_t nodes) {
  std::vector<char> blended(nodes, 0);
  for (const json& animation : gltf_list(gltf.document, "animations"))
    for (const json& channel : animation["channels"]) {
      const json& target = channel["target"];
      const auto node = static_cast<std::size_t>(target.value("node", -1));
      if (target["path"] == "weights" && node < nodes) blended[node] = 1;
    }
  return blended;
}

std::size_t gltf_joint_count(const GltfContainer& gltf, int skin, const std::string& user) {
  return gltf_element(gltf, "skins", "skin", skin, user)["joints"].size();
}

void read_rig(GltfContainer& gltf, const std::vector<GltfNode>& nodes,
              const std::vector<int>& parent, GltfRigParts parts, GltfWarnings& warnings,
              Scene& scene) {
  const std::vector<std::size_t> targets = target_counts(gltf, nodes);
  Rig rig;
  rig.animations = read_gltf_animations(gltf, nodes, targets, warnings);
  if (rig.animations.empty() && parts.deformations.empty()) return;
  const std::vector<char> moves = moving_nodes(rig.animations, nodes);
  const auto warn = [&](const std::vector<int>& of, const char* sentence) {
    for (const int node : of)
      if (moves[static_cast<std::size_t>(node)])
        warnings.add(sentence, nodes[static_cast<std::size_t>(node)].place);
  };
  warn(parts.lamp_nodes, "lamps that an animation moves stand still");
  warn(parts.hit_box_nodes, "hit boxes that an animation moves stand still");

  std::map<int, int> skin_of_file;
  for (Deformation& deformation : parts.deformations) {
    if (deformation.skin < 0) continue;
    const auto [known, is_new] =
        skin_of_file.try_emplace(deformation.skin, static_cast<int>(rig.skins.size()));
    if (is_new) rig.skins.push_back(read_skin(gltf, deformation.skin, nodes.size()));
    deformation.skin = known->second;
  }

  const std::vector<char> needed = needed_nodes(nodes, parent, moves, parts, rig.skins, scene);
  std::vector<char> places(nodes.size(), 0);
  for (const Instance& instance : scene.instances)
    places[static_cast<std::size_t>(instance.node)] = 1;
  std::vector<int> rig_node_of(nodes.size(), -1);
  std::vector<int> open;
  for (std::size_t n = nodes.size(); n-- > 0;)
    if (parent[n] < 0) open.push_back(static_cast<int>(n));
  while (!open.empty()) {
    const auto n = static_cast<std::size_t>(open.back());
    open.pop_back();
    if (!needed[n]) continue;
    rig_node_of[n] = static_cast<int>(rig.nodes.size());
    gltf.budget.spend(1, sizeof(RigNode) + nodes[n].name.size() + targets[n] * sizeof(double));
    RigNode made = rig_node(gltf, nodes[n], targets[n]);
    if (places[n]) made.file_node = static_cast<int>(n);
    if (parent[n] >= 0) made.parent = rig_node_of[static_cast<std::size_t>(parent[n])];
    const auto camera = parts.camera_of_node.find(static_cast<int>(n));
    if (camera != parts.camera_of_node.end()) made.camera = camera->second;
    rig.nodes.push_back(std::move(made));
    open.insert(open.end(), nodes[n].children.rbegin(), nodes[n].children.rend());
  }
  for (Skin& skin : rig.skins)
    for (int& joint : skin.joints) joint = rig_node_of[static_cast<std::size_t>(joint)];
  for (Deformation& deformation : parts.deformations)
    deformation.node = rig_node_of[static_cast<std::size_t>(deformation.node)];
  for (Animation& animation : rig.animations) {
    std::vector<AnimationChannel> kept;
    for (AnimationChannel& channel : animation.channels) {
      channel.node = rig_node_of[static_cast<std::size_t>(channel.node)];
      if (channel.node >= 0) kept.push_back(std::move(channel));
    }
    animation.channels = std::move(kept);
  }
  rig.deformations = std::move(parts.deformations);
  shape_meshes(rig, parts.instance_of_deformation, scene);
  if (!rig.animations.empty()) scene.rig = std::make_shared<const Rig>(std::move(rig));
}

}  // namespace omma
