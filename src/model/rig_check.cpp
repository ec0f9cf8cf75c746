// Indices, sizes and numbers of rigs.
#include "model/rig_check.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "model/text.h"
#include "omma/error.h"
#include "omma/rig.h"

namespace omma {
namespace {

struct Check {
  const Scene& scene;
  std::string place;  // as in errors

  [[noreturn]] void fail(const std::string& what) const {
    throw Error((scene.path.empty() ? "scene" : scene.path) + ": rig: " + place + ": " + what);
  }
  void index(int value, std::size_t size, const char* of, bool may_be_none = false) const {
    if (may_be_none && value == -1) return;
    if (value < 0 || static_cast<std::size_t>(value) >= size)
      fail("refers to " + std::string(of) + " " + std::to_string(value) + ", there are " +
           std::to_string(size));
  }
  void size(std::size_t found, std::size_t expected, const char* of) const {
    if (found != expected)
      fail("expected " + std::to_string(expected) + " " + of + ", found " + std::to_string(found));
  }
};

template <typename Numbers>
bool all_finite(const Numbers& numbers) {
  return std::all_of(std::begin(numbers), std::end(numbers),
                     [](double x) { return std::isfinite(x); });
}
bool all_finite(const std::vector<Vec3>& vectors) {
  return std::all_of(vectors.begin(), vectors.end(), [](Vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
  });
}

std::string numbered(const char* what, std::size_t index) {
  return std::string(what) + "[" + std::to_string(index) + "]";
}

void check_nodes(const Scene& scene) {
  const std::vector<RigNode>& nodes = scene.rig->nodes;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const Check check{scene, numbered("nodes", n)};
    check.index(nodes[n].parent, n, "parent", true);
    check.index(nodes[n].camera, scene.cameras.size(), "camera", true);
    if (!all_finite(nodes[n].translation_m) || !all_finite(nodes[n].rotation) ||
        !all_finite(nodes[n].scale) || !all_finite(nodes[n].weights))
      check.fail("its place is not finite");
    for (const auto& row : nodes[n].matrix.m)
      if (!all_finite(row)) check.fail("its matrix is not finite");
  }
}

void check_animations(const Scene& scene) {
  const Rig& rig = *scene.rig;
  for (std::size_t a = 0; a < rig.animations.size(); ++a)
    for (std::size_t c = 0; c < rig.animations[a].channels.size(); ++c) {
      const Check check{scene, numbered("animations", a) + "." + numbered("channels", c)};
      const AnimationChannel& channel = rig.animations[a].channels[c];
      check.index(channel.node, rig.nodes.size(), "node");
      const std::size_t keys = channel.times_s.size();
      if (keys == 0) check.fail("expected at least one key, found none");
      for (std::size_t k = 0; k < keys; ++k)
        if (!std::isfinite(channel.times_s[k]) ||
            (k > 0 && !(channel.times_s[k] > channel.times_s[k - 1])))
          check.fail("expected times that grow, found " + short_text(channel.times_s[k]) +
                     " s at key " + std::to_string(k));
      std::size_t components = 3;
      if (channel.part == AnimatedPart::rotation) components = 4;
      if (channel.part == AnimatedPart::weights)
        components = rig.nodes[static_cast<std::size_t>(channel.node)].weights.size();
      const bool is_cubic = channel.interpolation == Interpolation::cubic_spline;
      check.size(channel.values.size(), keys * components * (is_cubic ? 3 : 1), "numbers");
      if (!all_finite(channel.values)) check.fail("a value is not finite");
    }
}

void check_deformations(const Scene& scene) {
  const Rig& rig = *scene.rig;
  for (std::size_t s = 0; s < rig.skins.size(); ++s) {
    const Check check{scene, numbered("skins", s)};
    check.size(rig.skins[s].joint_from_mesh.size(), rig.skins[s].joints.size(), "matrices");
    for (const int joint : rig.skins[s].joints) check.index(joint, rig.nodes.size(), "node");
  }
  for (std::size_t d = 0; d < rig.deformations.size(); ++d) {
    const Check check{scene, numbered("deformations", d)};
    const Deformation& deformation = rig.deformations[d];
    check.index(deformation.mesh, scene.meshes.size(), "mesh");
    check.index(deformation.node, rig.nodes.size(), "node", deformation.targets.empty());
    check.index(deformation.skin, rig.skins.size(), "skin", true);
    const Mesh& mesh = scene.meshes[static_cast<std::size_t>(deformation.mesh)];
    const std::size_t vertices = mesh.positions.size();
    check.size(deformation.positions.size(), vertices, "vertices, as its mesh has");
    check.size(deformation.normals.size(), mesh.normals.size(), "normals, as its mesh has");
    bool finite = all_finite(deformation.positions) && all_finite(deformation.normals);
    for (const MorphTarget& target : deformation.targets) {
      if (!target.positions.empty()) check.size(target.positions.size(), vertices, "vertices");
      if (!target.normals.empty()) check.size(target.normals.size(), vertices, "normals");
      if (!target.normals.empty() && mesh.normals.empty()) check.fail("its mesh has no normals");
      finite = finite && all_finite(target.positions) && all_finite(target.normals);
    }
    if (!finite || !all_finite(deformation.weights)) check.fail("a number is not finite");
    if (deformation.skin < 0) continue;
    if (deformation.influences != 4 && deformation.influences != most_influences)
      check.fail("expected 4 or 8 bones a vertex, found " +
                 std::to_string(deformation.influences));
    const std::size_t bones = vertices * static_cast<std::size_t>(deformation.influences);
    check.size(deformation.joints.size(), bones, "joints");
    check.size(deformation.weights.size(), bones, "weights");
    const Skin& skin = rig.skins[static_cast<std::size_t>(deformation.skin)];
    for (const int joint : deformation.joints) check.index(joint, skin.joints.size(), "joint");
  }
}

}  // namespace

void check_rig(const Scene& scene) {
  if (scene.rig == nullptr) return;
  check_nodes(scene);
  check_animations(scene);
  check_deformations(scene);
}

}  // namespace omma
