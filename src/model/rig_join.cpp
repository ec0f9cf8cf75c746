// Rigs of scenes that are put elsewhere or together.
#include <cmath>
#include <utility>

#include "model/scene_place.h"
#include "model/transform.h"
#include "omma/error.h"
#include "omma/rig.h"

namespace omma {

Rig placed_rig(const Rig& rig, const Mat4& world_from_scene) {
  Rig placed = rig;
  RigNode root;
  root.has_matrix = true;
  root.matrix = world_from_scene;
  placed.nodes.insert(placed.nodes.begin(), root);
  for (std::size_t n = 1; n < placed.nodes.size(); ++n) ++placed.nodes[n].parent;  // of none: 0
  for (Skin& skin : placed.skins)
    for (int& joint : skin.joints) ++joint;
  for (Animation& animation : placed.animations)
    for (AnimationChannel& channel : animation.channels) ++channel.node;
  for (Deformation& deformation : placed.deformations) {
    if (deformation.node >= 0) ++deformation.node;
    if (deformation.skin < 0) continue;
    if (!(std::fabs(determinant(world_from_scene)) > least_determinant))
      throw Error(
          "world_from_scene: expected a transform with an inverse, as bones bend meshes of the "
          "scene");
    deformation.mesh_from_world = deformation.mesh_from_world * inverse(world_from_scene);
  }
  return placed;
}

Rig with_scaled_cameras(const Rig& rig, double factor) {
  Rig scaled = rig;
  for (std::size_t n = 0; n < rig.nodes.size(); ++n) {
    if (rig.nodes[n].camera < 0) continue;
    RigNode mount;
    mount.parent = static_cast<int>(n);
    mount.scale = {factor, factor, factor};
    std::swap(mount.camera, scaled.nodes[n].camera);
    scaled.nodes.push_back(std::move(mount));
  }
  return scaled;
}

void append_rig(Rig& rig, const Rig& other, const RigOffsets& before) {
  const auto nodes = static_cast<int>(rig.nodes.size());
  const auto skins = static_cast<int>(rig.skins.size());
  for (RigNode node : other.nodes) {
    if (node.parent >= 0) node.parent += nodes;
    if (node.file_node >= 0) node.file_node += before.nodes;
    if (node.camera >= 0) node.camera += before.cameras;
    rig.nodes.push_back(std::move(node));
  }
  for (Skin skin : other.skins) {
    for (int& joint : skin.joints) joint += nodes;
    rig.skins.push_back(std::move(skin));
  }
  for (Deformation deformation : other.deformations) {
    deformation.mesh += before.meshes;
    if (deformation.node >= 0) deformation.node += nodes;
    if (deformation.skin >= 0) deformation.skin += skins;
    rig.deformations.push_back(std::move(deformation));
  }
  for (Animation animation : other.animations) {
    for (AnimationChannel& channel : animation.channels) channel.node += nodes;
    rig.animations.push_back(std::move(animation));
  }
}

}  // namespace omma
