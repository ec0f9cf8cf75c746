// Channels between their keys, and nodes from the top down.
#include "model/animation.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "model/transform.h"
#include "omma/error.h"

namespace omma {
namespace {

const char* name_of(AnimatedPart part) {
  switch (part) {
    case AnimatedPart::translation:
      return "translation";
    case AnimatedPart::rotation:
      return "rotation";
    case AnimatedPart::scale:
      return "scale";
    case AnimatedPart::weights:
      return "weights";
  }
  return "";
}

std::string place_of(const Scene& scene) {
  return scene.path.empty() ? "scene" : scene.path;
}

std::string place_of(const Rig& rig, int animation) {
  const std::string& name = rig.animations[static_cast<std::size_t>(animation)].name;
  return "animations[" + std::to_string(animation) + "]" +
         (name.empty() ? "" : " \"" + name + "\"");
}

void normalize(std::vector<double>& quaternion) {
  double squares = 0;
  for (const double x : quaternion) squares += x * x;
  const double length = std::sqrt(squares);
  // Splines may pass through zero, where there is no direction to take.
  if (!(length > 0)) quaternion = {0, 0, 0, 1};
  if (length > 0)
    for (double& x : quaternion) x /= length;
}

std::size_t components_of(const AnimationChannel& channel) {
  const std::size_t each = channel.interpolation == Interpolation::cubic_spline ? 3 : 1;
  return channel.values.size() / channel.times_s.size() / each;
}

template <std::size_t count>
void set(std::array<double, count>& part, const std::vector<double>& value) {
  std::copy_n(value.begin(), count, part.begin());
}

}  // namespace

std::vector<double> eval_channel(const AnimationChannel& channel, double time_s) {
  const std::vector<double>& times = channel.times_s;
  const std::size_t size = components_of(channel);
  const bool is_cubic = channel.interpolation == Interpolation::cubic_spline;
  const std::size_t stride = is_cubic ? 3 * size : size, middle = is_cubic ? size : 0;
  const double* values = channel.values.data();
  const auto at_key = [&](std::size_t key) { return values + key * stride + middle; };
  const auto key_value = [&](std::size_t key) {
    return std::vector<double>(at_key(key), at_key(key) + size);
  };
  const bool is_rotation = channel.part == AnimatedPart::rotation;
  const auto next = std::upper_bound(times.begin(), times.end(), time_s);
  std::vector<double> value;
  if (next == times.begin()) {
    value = key_value(0);
  } else if (next == times.end()) {
    value = key_value(times.size() - 1);
  } else {
    const auto after = static_cast<std::size_t>(next - times.begin()), before = after - 1;
    const double width = times[after] - times[before], t = (time_s - times[before]) / width;
    const double *from = at_key(before), *to = at_key(after);
    switch (channel.interpolation) {
      case Interpolation::step:
        value = key_value(before);
        break;
      case Interpolation::linear:
        if (is_rotation) {
          const std::array<double, 4> turn = slerp(from, to, t);
          value.assign(turn.begin(), turn.end());
        } else {
          for (std::size_t i = 0; i < size; ++i) value.push_back((1 - t) * from[i] + t * to[i]);
        }
        break;
      case Interpolation::cubic_spline: {
        const double* leaving = from + size;    // tangents, per second
        const double* arriving = to - size;
        const double t2 = t * t, t3 = t2 * t;
        for (std::size_t i = 0; i < size; ++i)
          value.push_back((2 * t3 - 3 * t2 + 1) * from[i] +
                          width * (t3 - 2 * t2 + t) * leaving[i] + (3 * t2 - 2 * t3) * to[i] +
                          width * (t3 - t2) * arriving[i]);
        break;
      }
    }
  }
  if (is_rotation) normalize(value);
  return value;
}

std::vector<int> chosen_animations(const Scene& scene, std::span<const int> asked) {
  const std::size_t count = scene.rig == nullptr ? 0 : scene.rig->animations.size();
  if (count == 0) throw Error(place_of(scene) + ": there is no animation in it");
  const Rig& rig = *scene.rig;
  std::vector<int> chosen(asked.begin(), asked.end());
  if (chosen.empty())
    for (std::size_t i = 0; i < count; ++i) chosen.push_back(static_cast<int>(i));
  std::map<std::pair<int, AnimatedPart>, int> animation_of;
  for (const int animation : chosen) {
    if (animation < 0 || static_cast<std::size_t>(animation) >= count)
      throw Error("animation: expected an index of the " + std::to_string(count) +
                  " animations of " + place_of(scene) + ", found " + std::to_string(animation));
    for (const AnimationChannel& channel :
         rig.animations[static_cast<std::size_t>(animation)].channels) {
      const auto [known, is_new] =
          animation_of.try_emplace({channel.node, channel.part}, animation);
      if (is_new || known->second == animation) continue;
      const RigNode& node = rig.nodes[static_cast<std::size_t>(channel.node)];
      throw Error("animation: expected one of them, as " + place_of(rig, known->second) + " and " +
                  place_of(rig, animation) + " of " + place_of(scene) + " both move the " +
                  name_of(channel.part) + " of node \"" + node.name + "\"");
    }
  }
  return chosen;
}

RigPose eval_rig(const Rig& rig, std::span<const int> animations, double time_s) {
  std::vector<RigNode> nodes = rig.nodes;
  for (const int animation : animations)
    for (const AnimationChannel& channel :
         rig.animations[static_cast<std::size_t>(animation)].channels) {
      RigNode& node = nodes[static_cast<std::size_t>(channel.node)];
      const std::vector<double> value = eval_channel(channel, time_s);
      switch (channel.part) {
        case AnimatedPart::translation:
          set(node.translation_m, value);
          break;
        case AnimatedPart::rotation:
          set(node.rotation, value);
          break;
        case AnimatedPart::scale:
          set(node.scale, value);
          break;
        case AnimatedPart::weights:
          node.weights = value;
          break;
      }
    }
  RigPose pose;
  for (RigNode& node : nodes) {
    const Mat4 own =
        node.has_matrix ? node.matrix : transform_of(node.translation_m, node.rotation, node.scale);
    pose.world_from_node.push_back(
        node.parent < 0 ? own
                        : pose.world_from_node[static_cast<std::size_t>(node.parent)] * own);
    pose.weights.push_back(std::move(node.weights));
  }
  return pose;
}

std::vector<char> nodes_that_move(const Rig& rig) {
  std::vector<char> moves(rig.nodes.size(), 0);
  for (const Animation& animation : rig.animations)
    for (const AnimationChannel& channel : animation.channels)
      if (channel.part != AnimatedPart::weights) moves[static_cast<std::size_t>(channel.node)] = 1;
  for (std::size_t n = 0; n < moves.size(); ++n) {
    const int parent = rig.nodes[n].parent;
    if (parent >= 0 && moves[static_cast<std::size_t>(parent)]) moves[n] = 1;
  }
  return moves;
}

bool is_animated(const Rig& rig, const Deformation& deformation,
                 const std::vector<char>& node_moves) {
  if (deformation.skin >= 0)
    for (const int joint : rig.skins[static_cast<std::size_t>(deformation.skin)].joints)
      if (node_moves[static_cast<std::size_t>(joint)]) return true;
  if (deformation.targets.empty()) return false;
  for (const Animation& animation : rig.animations)
    for (const AnimationChannel& channel : animation.channels)
      if (channel.part == AnimatedPart::weights && channel.node == deformation.node) return true;
  return false;
}

int find_animation(const Scene& scene, const std::string& name) {
  std::string names;
  int found = -1, count = 0;
  const std::size_t all = scene.rig == nullptr ? 0 : scene.rig->animations.size();
  for (std::size_t i = 0; i < all; ++i) {
    const std::string& one = scene.rig->animations[i].name;
    names += (i == 0 ? "\"" : ", \"") + one + "\"";
    if (one == name && count++ == 0) found = static_cast<int>(i);
  }
  if (count == 1) return found;
  if (count > 1)
    throw Error("animation: " + std::to_string(count) + " of " + place_of(scene) + " are called \"" +
                name + "\"; expected an index");
  throw Error("animation: there is none called \"" + name + "\" in " + place_of(scene) +
              (all == 0 ? ", which has none" : "; there are " + names));
}

Mat4 camera_at(const Scene& scene, int camera, double time_s, const std::vector<int>& animations) {
  if (camera < 0 || static_cast<std::size_t>(camera) >= scene.cameras.size())
    throw Error("camera: expected an index of the " + std::to_string(scene.cameras.size()) +
                " cameras, found " + std::to_string(camera));
  const std::vector<int> chosen = chosen_animations(scene, animations);
  for (std::size_t n = 0; n < scene.rig->nodes.size(); ++n)
    if (scene.rig->nodes[n].camera == camera)
      return eval_rig(*scene.rig, chosen, time_s).world_from_node[n];
  return scene.cameras[static_cast<std::size_t>(camera)].world_from_camera;
}

}  // namespace omma
